"""
A straight-line program: outputs as sums, differences, products and quotients of inputs.

CasADi's symbols do the algebra (structural zeros and ones, constants); here each value is kept
once up to its sign, so that x y and -(y x) are one product, and negations melt into the sums.
"""

from collections import Counter

import casadi

from ..core.exceptions import BaxterDynamicsError

OPERATORS = {'+', '-', '*', '/'}


class Program:
    """
    Scalars computed from scalars.

    Parameters
    ----------
    inputs : sequence of casadi.SX
        Scalar symbols.
    outputs : sequence
        casadi.SX scalars or numbers.

    Attributes
    ----------
    nodes : list of tuple
        (operator, left, right) with nodes' indices, ('input', name, None) or
        ('number', value, None); each depends on earlier ones only.
    outputs : list of tuple
        (sign, index) of each output.

    """

    def __init__(self, inputs, outputs):
        self.nodes = []
        self._index = {}
        self._names = [symbol.name() for symbol in inputs]
        self.outputs = self._read(casadi.Function(
            'f', [casadi.vertcat(*inputs)], [casadi.densify(casadi.vertcat(*outputs))]))

    def counts(self) -> Counter:
        """Return how many of each operator the outputs need; 'negations' apart."""
        used = self.used()
        result = Counter(self.nodes[n][0] for n in used)
        return Counter({operator: result[operator] for operator in OPERATORS})

    def operations(self) -> int:
        """Return additions, subtractions, multiplications and divisions together."""
        return sum(self.counts().values())

    def used(self) -> list:
        """Return the indices of the nodes that the outputs need, in order."""
        wanted = {n for _, n in self.outputs}
        for n in range(len(self.nodes) - 1, -1, -1):
            if n in wanted and self.nodes[n][0] in OPERATORS:
                wanted.update(self.nodes[n][1:])
        return sorted(wanted)

    def _read(self, function) -> list:
        """Follow the instructions of a casadi.Function with one input and one output."""
        work, outputs = {}, {}
        for k in range(function.n_instructions()):
            operator = function.instruction_id(k)
            read = function.instruction_input(k)
            write = function.instruction_output(k)
            if operator == casadi.OP_INPUT:
                value = 1, self._node('input', self._names[read[1]])
            elif operator == casadi.OP_CONST:
                value = self._number(function.instruction_constant(k))
            elif operator == casadi.OP_OUTPUT:
                outputs[write[1]] = work[read[0]]
                continue
            elif operator in _RULES:
                value = _RULES[operator](self, *(work[i] for i in read))
            else:
                raise BaxterDynamicsError(f'no rule for the CasADi operation {operator}')
            work[write[0]] = value
        zero = self._number(0.0)
        return [outputs.get(i, zero) for i in range(function.numel_out(0))]

    def _node(self, operator: str, left, right=None) -> int:
        key = operator, left, right
        if key not in self._index:
            self._index[key] = len(self.nodes)
            self.nodes.append(key)
        return self._index[key]

    def _number(self, value: float) -> tuple:
        return (-1 if value < 0 else 1), self._node('number', abs(value))

    def _sum(self, x: tuple, y: tuple) -> tuple:
        zero = self._number(0.0)[1]
        if zero in (x[1], y[1]):
            return y if x[1] == zero else x
        (sign, left), (other, right) = sorted((x, y), key=lambda value: value[1])
        if left == right and sign != other:
            return 1, zero
        return sign, self._node('+' if sign == other else '-', left, right)

    def _difference(self, x: tuple, y: tuple) -> tuple:
        return self._sum(x, (-y[0], y[1]))

    def _product(self, x: tuple, y: tuple) -> tuple:
        return x[0] * y[0], self._node('*', *sorted((x[1], y[1])))

    def _quotient(self, x: tuple, y: tuple) -> tuple:
        one = self._number(1.0)
        inverse = y[0], self._node('/', one[1], y[1])
        return inverse if x == one else self._product(x, inverse)


_RULES = {
    casadi.OP_ADD: Program._sum,
    casadi.OP_SUB: Program._difference,
    casadi.OP_MUL: Program._product,
    casadi.OP_DIV: Program._quotient,
    casadi.OP_SQ: lambda program, x: program._product(x, x),
    casadi.OP_TWICE: lambda program, x: program._sum(x, x),
    casadi.OP_NEG: lambda program, x: (-x[0], x[1]),
    casadi.OP_INV: lambda program, x: program._quotient((1, program._number(1.0)[1]), x),
}

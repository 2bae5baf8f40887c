"""
Straight-line programs: outputs as sums, differences, products and quotients of inputs.

Each value is stored once up to its sign: x y and -(y x) are one product, and negations become
part of sums. Programs are written as assignments in infix notation, common to many languages.
"""

from collections import Counter
from collections.abc import Sequence
from typing import Any

Value = tuple[int, int]  # sign, index of its node
Node = tuple[str, Any, Any]
_Statement = tuple[str | None, int, int]  # target, or None for a temporary; sign; node

OPERATORS = {'+': 1, '-': 1, '*': 2, '/': 2}  # -> precedence
_LONGEST = 16  # maximum number of names in an expression


class Program:
    """Scalars computed from scalars."""

    def __init__(self) -> None:
        # (operator, left, right) with nodes' indices, ('input', name, None) or
        # ('number', value, None); each depends on earlier ones only.
        self.nodes: list[Node] = []
        self.outputs: list[Value] = []
        self._index: dict[Node, int] = {}

    def counts(self) -> Counter[str]:
        """Return the number of each operator that the outputs need."""
        used = Counter(self.nodes[n][0] for n in self.used())
        return Counter({operator: used[operator] for operator in OPERATORS})

    def operations(self) -> int:
        """Return the total number of operations."""
        return sum(self.counts().values())

    def used(self) -> list[int]:
        """Return the indices of the nodes that the outputs need, in order."""
        wanted = {n for _, n in self.outputs}
        for n in range(len(self.nodes) - 1, -1, -1):
            if n in wanted and self.nodes[n][0] in OPERATORS:
                wanted.update(self.nodes[n][1:])
        return sorted(wanted)

    def input(self, name: str) -> Value:  # noqa: A003
        """Return the value of an input."""
        return 1, self._node('input', name)

    def number(self, value: float) -> Value:
        """Return the value of a number."""
        return (-1 if value < 0 else 1), self._node('number', abs(value))

    def negative(self, x: Value) -> Value:
        """Return -x."""
        return -x[0], x[1]

    def sum(self, x: Value, y: Value) -> Value:  # noqa: A003
        """Return x + y."""
        zero = self.number(0.0)[1]
        if zero in (x[1], y[1]):
            return y if x[1] == zero else x
        (sign, left), (other, right) = sorted((x, y), key=lambda value: value[1])
        if left == right and sign != other:
            return 1, zero
        return sign, self._node('+' if sign == other else '-', left, right)

    def difference(self, x: Value, y: Value) -> Value:
        """Return x - y."""
        return self.sum(x, self.negative(y))

    def product(self, x: Value, y: Value) -> Value:
        """Return x y."""
        return x[0] * y[0], self._node('*', *sorted((x[1], y[1])))

    def quotient(self, x: Value, y: Value) -> Value:
        """Return x / y as a product with the inverse, which is shared by all quotients by y."""
        one = self.number(1.0)
        inverse = y[0], self._node('/', one[1], y[1])
        return inverse if x == one else self.product(x, inverse)

    def _node(self, operator: str, left: str | float, right: int | None = None) -> int:
        key = operator, left, right
        if key not in self._index:
            self._index[key] = len(self.nodes)
            self.nodes.append(key)
        return self._index[key]


class Writer:
    """Text of a program, whose inputs are renamed by ``names``."""

    def __init__(self, program: Program, names: dict[str, str]) -> None:
        self.nodes = list(program.nodes)
        self.used = program.used()
        self.outputs = list(program.outputs)
        self.names = names
        self.uses = Counter(n for _, n in set(self.outputs))
        for n in self.used:
            if self.nodes[n][0] in OPERATORS:
                self.uses.update(self.nodes[n][1:])
        self._turn_negative_outputs()
        self.named = self._choose_names()

    def write(self, targets: Sequence[str], reuse: bool = False) -> list[tuple[str, str]]:
        """
        Return assignments (name, expression) in order; outputs are assigned to the targets.

        ``reuse`` lets temporaries take the names of earlier ones, so that arrays are freed early;
        otherwise each name is assigned once.
        """
        statements: list[_Statement] = []  # each as soon as it can be
        outputs: dict[int, list[_Statement]] = {}
        for output, (sign, n) in zip(targets, self.outputs):
            outputs.setdefault(n, []).append((output, sign, n))
        for n in self.used:
            if n in self.named:
                statements.append((None, 1, n))
            statements += outputs.get(n, [])
        last = {leaf: i for i, statement in enumerate(statements)
                for leaf in self._read_by(*statement)}
        names: dict[int, str] = {}
        free: list[str] = []
        count, result = 0, []
        for i, (target, sign, n) in enumerate(statements):
            text = self._text(n, 0 if sign > 0 else 2, names, inside=target is None)
            if reuse:
                free += [names[leaf] for leaf in sorted(self._read_by(target, sign, n))
                         if last[leaf] == i]
            if target is None:
                if not free:
                    count += 1
                    free.append(f't{count}')
                target = names[n] = free.pop()
            result.append((target, text if sign > 0 else f'-{text}'))
        return result

    def _read_by(self, target: str | None, _: int, n: int) -> set[int]:
        """Return the named nodes that a statement reads."""
        return self._leaves(n) if target is None else self._leaves_of(n)

    def _turn_negative_outputs(self) -> None:
        """Swap differences where this removes the minus sign of an output."""
        inner = Counter(m for n in self.used if self.nodes[n][0] in OPERATORS
                        for m in self.nodes[n][1:])
        positive = {n for sign, n in self.outputs if sign > 0}
        for n in sorted({n for sign, n in self.outputs if sign < 0} - positive):
            if not inner[n] and self._can_turn(n):
                self._turn(n)
                self.outputs = [(1, m) if m == n else (s, m) for s, m in self.outputs]

    def _can_turn(self, n: int) -> bool:
        operator, left, right = self.nodes[n]
        if operator == '-':
            return True
        single = [m for m in (left, right) if operator in OPERATORS and self.uses[m] == 1
                  and left != right and self._can_turn(m)]
        return len(single) == 2 if operator == '+' else bool(single)

    def _turn(self, n: int) -> None:
        operator, left, right = self.nodes[n]
        if operator == '-':
            self.nodes[n] = operator, right, left
        elif operator == '+':
            self._turn(left)
            self._turn(right)
        else:
            self._turn(left if self.uses[left] == 1 and self._can_turn(left) else right)

    def _choose_names(self) -> set[int]:
        """Return the nodes that are assigned to a name; others are written inline."""
        sizes: dict[int, int] = {}
        named: set[int] = set()
        twice = {n for n, times in Counter(n for _, n in self.outputs).items() if times > 1}
        for n in self.used:
            if self.nodes[n][0] not in OPERATORS:
                sizes[n] = 1
                continue
            operands = self.nodes[n][1:]
            if sum(sizes[m] for m in operands) > _LONGEST:
                for m in sorted(operands, key=sizes.__getitem__)[::-1]:
                    if self.nodes[m][0] in OPERATORS:
                        named.add(m)
                        sizes[m] = 1
                    if sum(sizes[m] for m in operands) <= _LONGEST:
                        break
            sizes[n] = sum(sizes[m] for m in operands)
            if self.uses[n] > 1 or n in twice:
                named.add(n)
                sizes[n] = 1
        return named

    def _leaves(self, n: int) -> set[int]:
        """Return the named nodes in the expression of a named node."""
        return {leaf for m in self.nodes[n][1:] for leaf in self._leaves_of(m)}

    def _leaves_of(self, n: int) -> set[int]:
        if n in self.named:
            return {n}
        return self._leaves(n) if self.nodes[n][0] in OPERATORS else set()

    def _text(self, n: int, precedence: int, names: dict[int, str], inside: bool = False) -> str:
        operator, left, right = self.nodes[n]
        if operator == 'input':
            name: str = left
            return self.names.get(name, name)
        if operator == 'number':
            return repr(left)
        if n in names and not inside:
            return names[n]
        own = OPERATORS[operator]
        # The order of evaluation is kept: a - (b - c) and a (b c) keep their parentheses.
        left = self._text(left, own, names)
        right = self._text(right, own + (1 if operator != '+' else 0), names)
        text = f'{left} {operator} {right}'
        return f'({text})' if own < precedence else text

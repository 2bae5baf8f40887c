"""
Straight-line program: outputs as sums, differences, products and quotients of inputs.

Each value is stored once up to its sign: x y and -(y x) are one product, and negations become
part of sums. A value is a pair (sign, index of its node).
"""

from collections import Counter
from typing import Any

Value = tuple[int, int]
Node = tuple[str, Any, Any]

OPERATORS = {'+', '-', '*', '/'}


class Program:
    """
    Scalars computed from scalars.

    Attributes
    ----------
    nodes : list of tuple
        (operator, left, right) with nodes' indices, ('input', name, None) or
        ('number', value, None); each depends on earlier ones only.
    outputs : list of tuple
        The value of each output.

    """

    def __init__(self) -> None:
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

"""Text of a program: assignments in infix notation, common to many languages."""

from collections import Counter
from collections.abc import Sequence

from .program import OPERATORS, Program

_Statement = tuple[str | None, int, int]  # target, or None for a temporary; sign; node

_PRECEDENCE = {'+': 1, '-': 1, '*': 2, '/': 2}


def assignments(program: Program, outputs: Sequence[str], names: dict[str, str] | None = None,
                reuse: bool = False, longest: int = 16,
                prefix: str = 't') -> list[tuple[str, str]]:
    """
    Write a program as assignments, (name, expression) in order.

    Parameters
    ----------
    program : Program
        Program to write.
    outputs : sequence of str
        Target of each output.
    names : dict, optional
        Name of an input -> name in the text.
    reuse : bool, optional
        Whether names of temporaries are reused, so that arrays are freed early; otherwise each
        name is assigned once.
    longest : int, optional
        Maximum number of names in an expression; 2 gives one operation per line.
    prefix : str, optional
        Prefix of the numbered names of temporaries.

    """
    return _Writer(program, names or {}, longest).write(outputs, reuse, prefix)


class _Writer:

    def __init__(self, program: Program, names: dict[str, str], longest: int) -> None:
        self.nodes = list(program.nodes)
        self.used = program.used()
        self.outputs = list(program.outputs)
        self.names = names
        self.uses = Counter(n for _, n in set(self.outputs))
        for n in self.used:
            if self.nodes[n][0] in OPERATORS:
                self.uses.update(self.nodes[n][1:])
        self._turn_negative_outputs()
        self.named = self._choose_names(longest)

    def write(self, targets: Sequence[str], reuse: bool, prefix: str) -> list[tuple[str, str]]:
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
                    free.append(f'{prefix}{count}')
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

    def _choose_names(self, longest: int) -> set[int]:
        """Return the nodes that are assigned to a name; others are written inline."""
        sizes: dict[int, int] = {}
        named: set[int] = set()
        twice = {n for n, times in Counter(n for _, n in self.outputs).items() if times > 1}
        for n in self.used:
            if self.nodes[n][0] not in OPERATORS:
                sizes[n] = 1
                continue
            operands = self.nodes[n][1:]
            if sum(sizes[m] for m in operands) > longest:
                for m in sorted(operands, key=sizes.__getitem__)[::-1]:
                    if self.nodes[m][0] in OPERATORS:
                        named.add(m)
                        sizes[m] = 1
                    if sum(sizes[m] for m in operands) <= longest:
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
        own = _PRECEDENCE[operator]
        # The order of evaluation is kept: a - (b - c) and a (b c) keep their parentheses.
        left = self._text(left, own, names)
        right = self._text(right, own + (1 if operator != '+' else 0), names)
        text = f'{left} {operator} {right}'
        return f'({text})' if own < precedence else text

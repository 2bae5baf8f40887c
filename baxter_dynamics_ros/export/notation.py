"""Formulas in LaTeX: sums collected, products explicit."""

import ast
import re
from typing import Any

_Factors = tuple[Any, ...]  # symbols and, in brackets, sums as pairs of their own
_Sum = dict[_Factors, float]  # factors -> coefficient

_SIGNS = {ast.Add: 1, ast.Sub: -1}
_SYMBOL = re.compile('([a-z]+)_?([0-9]+|[xyz])')
# Names whose LaTeX has another letter than theirs.
_LETTERS = {'izz': ('I', 'zz'), 'up': ('u', ''), 'hx': ('h', 'x'), 'hy': ('h', 'y'),
            **{element: ('J', element) for element in ('xx', 'yy', 'xy', 'xz', 'yz')}}
_ORDER = ('adu', 'sc', 'IJh', 't')  # of a product's symbols, by their letters


def symbol(name: str) -> str:
    """Return a name such as t12, s3, xx7 or up_z in LaTeX: a letter and its index."""
    match = _SYMBOL.fullmatch(name)
    assert match is not None, name
    word, index = match.groups()
    letter, element = _LETTERS.get(word, (word, ''))
    return f'{letter}_{{{element}{index}}}'


def formula(expression: ast.expr) -> str:
    r"""Return an expression of names, numbers, +, - and * as LaTeX, factors parted by ``\,``."""
    return _sum(_terms(expression))


def _terms(node: Any) -> _Sum:
    """Return a sum as factors -> coefficient; a factor is a symbol or, in brackets, a sum."""
    if isinstance(node, ast.Name):
        return {(symbol(node.id),): 1}
    if isinstance(node, ast.Constant):
        value: Any = node.value
        return {(): value} if value else {}
    if isinstance(node, ast.UnaryOp):
        return _scaled(_terms(node.operand), -1)
    left, right = _terms(node.left), _terms(node.right)
    if isinstance(node.op, ast.Mult):
        return _product(left, right)
    result = dict(left)
    for factors, coefficient in _scaled(right, _SIGNS[type(node.op)]).items():
        result[factors] = result.get(factors, 0) + coefficient
    return {factors: coefficient for factors, coefficient in result.items() if coefficient}


def _product(left: _Sum, right: _Sum) -> _Sum:
    factors: _Factors = ()
    coefficient = 1.0
    for terms in (left, right):
        if len(terms) > 1:
            factors += (tuple(terms.items()),)
        else:
            for more, number in terms.items():
                factors, coefficient = factors + more, coefficient * number
    return {factors: coefficient} if left and right else {}


def _scaled(terms: _Sum, factor: int) -> _Sum:
    return {factors: factor * coefficient for factors, coefficient in terms.items()}


def _sum(terms: _Sum) -> str:
    if not terms:
        return '0'
    items = list(terms.items())
    # A sum does not begin with a minus sign if it can help it.
    positive = next((i for i, (_, coefficient) in enumerate(items) if coefficient > 0), 0)
    first, rest = items.pop(positive), items
    text = ('-' if first[1] < 0 else '') + _term(*first)
    return text + ''.join(f' {"-" if term[1] < 0 else "+"} {_term(*term)}' for term in rest)


def _term(factors: _Factors, coefficient: float) -> str:
    size = abs(coefficient)
    texts = [] if size == 1 and factors else [f'{size:g}']
    texts += sorted((x for x in factors if isinstance(x, str)), key=_place)
    return r'\,'.join(texts + [_bracket(x) for x in factors if not isinstance(x, str)])


def _place(text: str) -> int:
    """Return a symbol's place in a product: lengths, sines, inertias, what they make up."""
    return next(i for i, letters in enumerate(_ORDER) if text[0] in letters)


def _bracket(terms: tuple[tuple[_Factors, float], ...]) -> str:
    text = _sum(dict(terms))
    return f'[{text}]' if '(' in text else f'({text})'

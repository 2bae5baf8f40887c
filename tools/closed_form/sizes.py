"""
Operation counts of M, C and G, from the expanded equations of the paper to body frames.

``python -m tools.closed_form sizes`` prints the table.
"""

from collections.abc import Iterable
from typing import NamedTuple

from baxter_dynamics_ros.model import paper_tables
import casadi
import numpy as np
from numpy.typing import NDArray

from .derivation import program_of, trace
from .frames import N, Rows, Scalar, Scalars
from .program import Program
from .quantities import QUANTITIES, Quantity

Objects = NDArray[np.object_]
_Symbols = dict[tuple[int, int, int], Scalar]

_Q = np.zeros((4, 4), object)  # eq. (11)
_Q[0, 1], _Q[1, 0] = -1, 1
_VERTICAL = np.array([0, 0, 1], object)


class Size(NamedTuple):
    """One row of the table."""

    form: str
    additions: 'int | None'  # and subtractions
    multiplications: 'int | None'
    total: int


class _Tally:
    """Number that only counts the operations applied to it."""

    additions = multiplications = 0

    def __add__(self, other: object) -> '_Tally':
        _Tally.additions += 1
        return self

    def __mul__(self, other: object) -> '_Tally':
        _Tally.multiplications += 1
        return self

    __radd__, __rmul__ = __add__, __mul__


def expanded_terms() -> int:
    """
    Count the terms of M, h_ikm (k <= m) and G where eqs. (6) to (8) are multiplied out.

    Like terms are not collected; each entry of eq. (2) that is not zero is a term, alpha being
    +-90 degrees or 0, and J of eq. (12) is full.
    """
    links = [(np.array(a) != 0).astype(int).astype(object) for a in _pattern()]
    axis: Objects = np.abs(_Q)
    mass, symbols, gravity = _equations(links, axis, [np.ones((4, 4), int).astype(object)] * N)
    return sum(mass.ravel()) + sum(symbols.values()) + sum(gravity)


def dense_operations() -> Size:
    """Count the operations of eqs. (6) to (8) as matrix code, each product computed once."""
    _Tally.additions = _Tally.multiplications = 0
    full = np.full((4, 4), _Tally(), object)
    mass, symbols, _ = _equations([full] * N, full, [full] * N, triangle=True)
    _christoffel_matrix(symbols, [_Tally()] * N)
    return Size('eqs. (6) to (8) as matrix code', _Tally.additions, _Tally.multiplications,
                _Tally.additions + _Tally.multiplications)


def symbolic_operations() -> Size:
    """Count the same without structural zeros and with common subexpressions shared."""
    sine, cosine, rates = ([casadi.SX.sym(f'{x}{i}') for i in range(N)] for x in ('s', 'c', 'v'))
    symbols = [*sine, *cosine, *rates]
    links = []
    for i, pattern in enumerate(_pattern(sine, cosine)):
        a, d = casadi.SX.sym(f'a{i}'), casadi.SX.sym(f'd{i}')
        symbols += [a, d]
        links.append(_matrix([[entry * {'a': a, 'd': d}[length] if length else entry
                               for entry, length in zip(row, lengths)]
                              for row, lengths in zip(pattern, _lengths(i))]))
    pseudo = []
    for i in range(N):
        elements = [casadi.SX.sym(f'j{i}{k}') for k in range(10)]
        symbols += elements
        at = [[0, 3, 4, 6], [3, 1, 5, 7], [4, 5, 2, 8], [6, 7, 8, 9]]
        pseudo.append(_matrix([[elements[k] for k in row] for row in at]))
    mass, h, gravity = _equations(links, _Q, pseudo, triangle=True)
    outputs = [*mass.flat, *_christoffel_matrix(h, rates).flat, *gravity]
    return _size('the same, zeros left out, common subexpressions shared',
                 trace(symbols, outputs))


def body_frame_sizes() -> list[Size]:
    """Return the sizes of our formulation's quantities, gravity along the axis of joint 1."""
    both = Quantity('', (), (), lambda f: (f.mass_matrix(), f.christoffel_symbols()))
    rows = [('M, C and G, in body frames (ours)', QUANTITIES['terms']),
            ('M alone', QUANTITIES['mass_matrix']),
            ('C alone', QUANTITIES['coriolis_matrix']),
            ('G alone', QUANTITIES['gravity']),
            ('M, C qd and G', QUANTITIES['torque_terms']),
            ('C qd alone', QUANTITIES['coriolis_torque']),
            ('all Christoffel symbols and M', both),
            ('p = M qd, C^T qd and G', QUANTITIES['momentum_terms']),
            ('tau', QUANTITIES['inverse_dynamics']),
            ('qdd, with 7 divisions', QUANTITIES['forward_dynamics']),
            ('regressor Y (7 x 43)', QUANTITIES['regressor']),
            ('d tau/dq and d tau/dqd', QUANTITIES['inverse_dynamics_gradient'])]
    return [_size(name, program_of(quantity, tilted=False)) for name, quantity in rows]


def table() -> str:
    """Return the table, in Markdown."""
    rows = [Size('eqs. (6) to (8) multiplied out: terms', None, None, expanded_terms()),
            dense_operations(), symbolic_operations(), *body_frame_sizes()]
    lines = ['| form | + and - | * and / | together |', '|---|--:|--:|--:|']
    for form, *counts in rows:
        cells = ' | '.join('' if count is None else f'{count:,}' for count in counts)
        lines.append(f'| {form} | {cells} |')
    return '\n'.join(lines)


def _size(form: str, program: Program) -> Size:
    counts = program.counts()
    additions, multiplications = counts['+'] + counts['-'], counts['*'] + counts['/']
    return Size(form, additions, multiplications, additions + multiplications)


def _pattern(sine: Scalars = (1,) * N, cosine: Scalars = (1,) * N) -> list[Rows]:
    """Return the entries of eq. (2) of each link, without the lengths in the last column."""
    result = []
    for i, (d, a, alpha, _) in enumerate(paper_tables.TABLE_II):
        ca, sa = round(np.cos(alpha)), round(np.sin(alpha))
        s, c = sine[i], cosine[i]
        result.append([[c, -s * ca, s * sa, c if a else 0], [s, c * ca, -c * sa, s if a else 0],
                       [0, sa, ca, 1 if d else 0], [0, 0, 0, 1]])
    return result


def _lengths(i: int) -> list[list[str | None]]:
    """Return which length multiplies each entry of eq. (2)."""
    return [[None] * 3 + ['a'], [None] * 3 + ['a'], [None] * 3 + ['d'], [None] * 4]


def _equations(links: list[Objects], axis: Objects, pseudo: list[Objects],
               triangle: bool = False) -> tuple[Objects, _Symbols, list[Scalar]]:
    """
    Return M, {(i, k, m): h_ikm, k <= m} and G of eqs. (6) to (8), each product formed once.

    ``triangle`` leaves the lower half of M to its symmetry.
    """
    to = {}  # {i}T_j
    for i in range(N):
        to[i, i + 1] = links[i]
        for j in range(i + 2, N + 1):
            to[i, j] = to[i, j - 1].dot(links[j - 1])
    turned = {key: axis.dot(matrix) for key, matrix in to.items()}  # Q {i}T_j
    first = {(j, k): to[0, k].dot(turned[k, j + 1]) if k else turned[0, j + 1]
             for j in range(N) for k in range(j + 1)}  # U_jk
    second = {}  # U_jkm, k <= m
    for j in range(N):
        for m in range(j + 1):
            for k in range(m + 1):
                inner = turned[k, m].dot(turned[m, j + 1]) if k < m else axis.dot(
                    turned[m, j + 1])
                second[j, k, m] = to[0, k].dot(inner) if k else inner
    weighted = {key: u.dot(pseudo[key[0]]) for key, u in first.items()}
    weighted_2 = {key: u.dot(pseudo[key[0]]) for key, u in second.items()}
    mass = np.zeros((N, N), object)
    for i in range(N):
        for k in range(i if triangle else 0, N):
            mass[i, k] = _sum(_trace(weighted[j, k], first[j, i]) for j in range(max(i, k), N))
            if triangle:
                mass[k, i] = mass[i, k]
    h = {(i, k, m): _sum(_trace(weighted_2[j, k, m], first[j, i]) for j in range(max(i, m), N))
         for i in range(N) for m in range(N) for k in range(m + 1)}
    gravity = [_sum(_VERTICAL.dot(weighted[j, i][:3, 3]) for j in range(i, N)) for i in range(N)]
    return mass, h, gravity


def _christoffel_matrix(h: _Symbols, rates: Scalars) -> Objects:
    result = np.zeros((N, N), object)
    for i in range(N):
        for k in range(N):
            result[i, k] = _sum(h[i, min(k, m), max(k, m)] * rates[m] for m in range(N))
    return result


def _trace(x: Objects, y: Objects) -> Scalar:
    """Return Tr(x y^T)."""
    return _sum(x[i].dot(y[i]) for i in range(4))


def _sum(values: Iterable[Scalar]) -> Scalar:
    values = list(values)
    result = values[0]
    for value in values[1:]:
        result = result + value
    return result


def _matrix(rows: Rows) -> Objects:
    result = np.empty((len(rows), len(rows[0])), object)
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            result[i, j] = entry
    return result

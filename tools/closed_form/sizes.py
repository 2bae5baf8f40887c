"""
Operation counts of M, C and G, from the expanded equations of the paper to body frames.

``python -m tools.closed_form sizes`` prints the table.
"""

from collections.abc import Callable, Iterable
from typing import Any

from baxter_dynamics_ros.model import paper_tables
import casadi
import numpy as np

from .derivation import program_of, trace
from .frames import N, Rows, Scalar, Scalars
from .program import Program
from .quantities import QUANTITIES, Quantity

_Matrix = Any  # of integers or objects of NumPy, or of CasADi
_Symbols = dict[tuple[int, int, int], Scalar]

_Q = [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]  # eq. (11)
_VERTICAL = [[0, 0, 1]]
_BOTH = Quantity('', (), (), lambda arm: (arm.mass_matrix(), arm.christoffel_symbols()))
# Row of the table -> quantity, in body frames, gravity along the axis of joint 1.
_OURS = {'M, C and G, in body frames (ours)': QUANTITIES['terms'],
         'M alone': QUANTITIES['mass_matrix'],
         'C alone': QUANTITIES['coriolis_matrix'],
         'G alone': QUANTITIES['gravity'],
         'M, C qd and G': QUANTITIES['torque_terms'],
         'C qd alone': QUANTITIES['coriolis_torque'],
         'all Christoffel symbols and M': _BOTH,
         'p = M qd, C^T qd and G': QUANTITIES['momentum_terms'],
         'tau': QUANTITIES['inverse_dynamics'],
         'qdd, with 7 divisions': QUANTITIES['forward_dynamics'],
         'regressor Y (7 x 43)': QUANTITIES['regressor'],
         'd tau/dq and d tau/dqd': QUANTITIES['inverse_dynamics_gradient']}


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


def table() -> str:
    """Return the table, in Markdown."""
    programs = {'the same, zeros left out, common subexpressions shared': symbolic_program(),
                **{form: program_of(quantity, tilted=False) for form, quantity in _OURS.items()}}
    sizes = [('eqs. (6) to (8) as matrix code', *dense_operations())]
    for form, program in programs.items():
        counts = program.counts()
        sizes.append((form, counts['+'] + counts['-'], counts['*'] + counts['/']))
    return '\n'.join([
        '| form | + and - | * and / | together |', '|---|--:|--:|--:|',
        f'| eqs. (6) to (8) multiplied out: terms |  |  | {expanded_terms():,} |',
        *(f'| {form} | {additions:,} | {multiplications:,} | {additions + multiplications:,} |'
          for form, additions, multiplications in sizes)])


def expanded_terms() -> int:
    """
    Count the terms of M, h_ikm (k <= m) and G where eqs. (6) to (8) are multiplied out.

    Like terms are not collected; each entry of eq. (2) that is not zero is a term, alpha being
    +-90 degrees or 0, and J of eq. (12) is full.
    """
    ones = (1,) * N
    links = [np.abs(link) for link in _links(ones, ones, ones, ones)]
    mass, symbols, gravity = _equations(
        links, np.abs(_Q), [np.ones((4, 4), int)] * N, np.array(_VERTICAL), np.vdot)
    return int(np.sum(mass) + sum(symbols.values()) + np.sum(gravity))


def dense_operations() -> tuple[int, int]:
    """Count additions and multiplications of eqs. (6) to (8), each product computed once."""
    _Tally.additions = _Tally.multiplications = 0
    full = np.full((4, 4), _Tally(), object)
    _, symbols, _ = _equations([full] * N, full, [full] * N, np.array(_VERTICAL, object),
                               lambda x, y: (x * y).sum())
    _christoffel_matrix(symbols, [_Tally()] * N)
    return _Tally.additions, _Tally.multiplications


def symbolic_program() -> Program:
    """Return the same without structural zeros and with common subexpressions shared."""
    sine, cosine, a, d, rates = ([casadi.SX.sym(f'{x}{i}') for i in range(N)] for x in 'scadv')
    pseudo = [[casadi.SX.sym(f'j{i}_{k}') for k in range(10)] for i in range(N)]
    place = [[0, 3, 4, 6], [3, 1, 5, 7], [4, 5, 2, 8], [6, 7, 8, 9]]
    mass, h, gravity = _equations(
        list(map(_symbolic, _links(sine, cosine, a, d))), _symbolic(_Q),
        [_symbolic([[elements[k] for k in row] for row in place]) for elements in pseudo],
        casadi.SX(_VERTICAL), casadi.dot)
    inputs = [*sine, *cosine, *a, *d, *rates, *(x for elements in pseudo for x in elements)]
    return trace(inputs, [*mass.flat, *_christoffel_matrix(h, rates).flat, *gravity])


def _symbolic(rows: Rows) -> _Matrix:
    return casadi.vertcat(*(casadi.horzcat(*row) for row in rows))


def _links(sine: Scalars, cosine: Scalars, a: Scalars, d: Scalars) -> list[Rows]:
    """Return eq. (2) of each link, with the angles alpha and the zero lengths of Table II."""
    result = []
    for i, (has_d, has_a, alpha, _) in enumerate(paper_tables.TABLE_II):
        ca, sa = round(np.cos(alpha)), round(np.sin(alpha))
        s, c = sine[i], cosine[i]
        result.append([
            [c, -s * ca, s * sa, a[i] * c if has_a else 0],
            [s, c * ca, -c * sa, a[i] * s if has_a else 0],
            [0, sa, ca, d[i] if has_d else 0], [0, 0, 0, 1]])
    return result


def _equations(links: list[_Matrix], axis: _Matrix, pseudo: list[_Matrix], vertical: _Matrix,
               dot: Callable[[_Matrix, _Matrix], Scalar]) -> tuple[_Matrix, _Symbols, Scalars]:
    """
    Return M, {(i, k, m): h_ikm, k <= m} and G of eqs. (6) to (8), each product formed once.

    ``dot`` is Tr(x y^T).
    """
    to = {}  # {i}T_j
    for i in range(N):
        to[i, i + 1] = links[i]
        for j in range(i + 2, N + 1):
            to[i, j] = to[i, j - 1] @ links[j - 1]
    turned = {key: axis @ matrix for key, matrix in to.items()}  # Q {i}T_j
    first = {(j, k): to[0, k] @ turned[k, j + 1] if k else turned[0, j + 1]
             for j in range(N) for k in range(j + 1)}  # U_jk
    second = {}  # U_jkm, k <= m
    for j in range(N):
        for m in range(j + 1):
            for k in range(m + 1):
                inner = (turned[k, m] if k < m else axis) @ turned[m, j + 1]
                second[j, k, m] = to[0, k] @ inner if k else inner
    weighted = {key: u @ pseudo[key[0]] for key, u in first.items()}
    weighted_2 = {key: u @ pseudo[key[0]] for key, u in second.items()}
    mass = np.zeros((N, N), object)
    for i in range(N):
        for k in range(i, N):
            mass[i, k] = mass[k, i] = _sum(dot(weighted[j, k], first[j, i])
                                           for j in range(k, N))
    h = {(i, k, m): _sum(dot(weighted_2[j, k, m], first[j, i]) for j in range(max(i, m), N))
         for i in range(N) for m in range(N) for k in range(m + 1)}
    gravity = [_sum(vertical @ weighted[j, i][:3, 3] for j in range(i, N)) for i in range(N)]
    return mass, h, gravity


def _christoffel_matrix(h: _Symbols, rates: Scalars) -> _Matrix:
    result = np.zeros((N, N), object)
    for i, k in np.ndindex(N, N):
        result[i, k] = _sum(h[i, min(k, m), max(k, m)] * rates[m] for m in range(N))
    return result


def _sum(values: Iterable[Scalar]) -> Scalar:
    first, *rest = values
    return sum(rest, first)

"""The tables equal the printed ones; the two corrections."""

from math import pi
import re

from baxter_dynamics_ros import ArgumentError
from baxter_dynamics_ros.model import paper_tables, S1
from baxter_dynamics_ros.model.parameters import (INERTIA_AT_ORIGIN, paper_parameters,
                                                  pseudo_inertia, THETA_2_OFFSET)
import numpy as np
import pytest


def test_tables_and_gravity_as_printed(shared):
    path = shared / 'PAPER.md'
    if not path.is_file():
        pytest.skip(f'{path} is missing: it is the paper')
    paper = path.read_text(encoding='utf-8')
    rows = _rows(paper, 'TABLE II')
    assert [row[1] for row in rows] == [rf'$\theta_{{{i}}}$' for i in range(1, 8)]
    angles = {'0': 0.0, r'$\pi / 2$': pi / 2, r'$-\pi / 2$': -pi / 2}
    printed = [(float(d), float(a), angles[alpha], float(mass))
               for _, _, d, a, alpha, mass in rows]
    assert paper_tables.TABLE_II == tuple(printed)
    rows = [tuple(float(cell) for cell in row[1:]) for row in _rows(paper, 'TABLE III')]
    assert len(rows) == 14  # xx yy zz of all links, then xy yz xz
    assert paper_tables.TABLE_III == tuple(a + b for a, b in zip(rows[:7], rows[7:]))
    rows = [tuple(float(cell) for cell in row[1:]) for row in _rows(paper, 'TABLE IV')]
    assert paper_tables.TABLE_IV == tuple(rows)
    x, y, z, _ = re.search(r'\\mathbf{g}=\[([^]]+)\]', paper)[1].split(',')
    assert paper_tables.GRAVITY == (float(x), float(y), float(z))


def test_pseudo_inertia_without_corrections():
    rows = zip(paper_parameters(()).pseudo_inertia, paper_tables.TABLE_II,
               paper_tables.TABLE_III, paper_tables.TABLE_IV)
    for result, (_, _, _, m), (xx, yy, zz, xy, yz, xz), (x, y, z) in rows:
        np.testing.assert_allclose(result, [
            [(-xx + yy + zz) / 2, xy, xz, m * x],
            [xy, (xx - yy + zz) / 2, yz, m * y],
            [xz, yz, (xx + yy - zz) / 2, m * z],
            [m * x, m * y, m * z, m]], rtol=0.0, atol=1e-16)


def test_corrections_change_only_theta_2_and_only_second_moments():
    before, after = paper_parameters(()), paper_parameters({THETA_2_OFFSET})
    assert _changed(before, after) == {'corrections', 'theta_offset'}
    np.testing.assert_array_equal(after.theta_offset, pi / 2 * (np.arange(7) == S1))
    after = paper_parameters({INERTIA_AT_ORIGIN})
    assert _changed(before, after) == {'corrections', 'pseudo_inertia'}
    np.testing.assert_array_equal(before.pseudo_inertia[:, 3], after.pseudo_inertia[:, 3])
    with pytest.raises(ArgumentError, match='corrections: .*theta_3.*expected.*theta_2_offset'):
        paper_parameters({'theta_3'})


def test_corrected_pseudo_inertia_is_the_second_moment_of_mass(rng):
    # Of a body of twenty points J = sum m [x y z 1]^T [x y z 1] can be had without any formula.
    mass, points = rng.uniform(0.1, 1.0, 20), rng.uniform(-0.3, 0.3, (20, 3))
    center = mass @ points / mass.sum()
    inertia = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(mass, points - center))
    result = pseudo_inertia(inertia, mass.sum(), center)
    homogeneous = np.column_stack([points, np.ones(20)])
    np.testing.assert_allclose(result, homogeneous.T @ (mass[:, None] * homogeneous),
                               rtol=0.0, atol=1e-14)


def _rows(paper, title):
    """Return the cells of the rows that begin with a link's number in the table of that title."""
    table = paper.split(f'\n{title}\n')[1].split('\n\n')[1]
    rows = [[cell.strip() for cell in line.strip('|').split('|')] for line in table.split('\n')]
    return [row for row in rows if row[0].isdigit()]


def _changed(before, after):
    return {name for name in vars(before)
            if not np.array_equal(getattr(before, name), getattr(after, name))}

"""The table of base parameters: values, units and compositions."""

import re

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.export.base_table import base_table, composition
from baxter_dynamics_ros.model.base_parameters import base_parameters, TILTED_NAMES
import numpy as np
import pytest

AT = {'XX': (0, 0), 'YY': (1, 1), 'ZZ': (2, 2), 'XY': (0, 1), 'XZ': (0, 2), 'YZ': (1, 2),
      'HX': (0, 3), 'HY': (1, 3), 'HZ': (2, 3)}


def moments(arm, links):
    """Return the moments of links (7, 4, 4) in the paper's frames, as the table defines them."""
    p, values = arm.parameters, {}
    for k in range(7):
        s, c = np.sin(p.alpha[k]), np.cos(p.alpha[k])
        # Of frame {k} in body frame k: eq. (2) without its rotation by theta.
        pose = np.array([[1, 0, 0, p.a[k]], [0, c, -s, 0], [0, s, c, p.d[k]], [0, 0, 0, 1]])
        moved = pose @ links[k] @ pose.T
        values.update({f'{name}{k + 1}': moved[place] for name, place in AT.items()})
        values[f'M{k + 1}'] = links[k:, 3, 3].sum()
        values[f'a{k + 1}'], values[f'd{k + 1}'] = p.a[k], p.d[k]
    return values


def test_compositions_are_the_base_parameters(rng):
    arm = BaxterArm()
    half = rng.normal(size=(7, 4, 4))
    links = half @ half.swapaxes(-1, -2)
    values = moments(arm, links)
    expected = dict(zip(TILTED_NAMES, base_parameters(arm.parameters, links)))
    for name, value in expected.items():
        code = re.sub(r' (?=[A-Za-z])', '*', composition(name).replace('^', '**'))
        code = re.sub(r'([+-])\*', r'\1', code)
        assert eval(code, dict(values)) == pytest.approx(value, rel=1e-12), name


def test_the_numbers_and_their_units(arm):
    rows = re.findall(r'^(\w+) +(\S+) (kg m|kg m\^2) +=', base_table(arm), re.MULTILINE)
    assert [name for name, _, _ in rows] == list(TILTED_NAMES)[:len(arm.base_parameters)]
    np.testing.assert_allclose([float(value) for _, value, _ in rows], arm.base_parameters,
                               rtol=1e-6)
    for name, _, unit in rows:
        assert unit == ('kg m' if name[0] == 'h' else 'kg m^2')

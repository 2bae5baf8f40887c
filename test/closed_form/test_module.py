"""The generated module is what the generator writes, and runs without it."""

from baxter_dynamics_ros.closed_form.quantities import (CONSTANTS, formulate, QUANTITIES,
                                                        TILTED_REGRESSOR)
from baxter_dynamics_ros.model import _closed_form
import numpy as np
import pytest


@pytest.mark.parametrize('name', [*QUANTITIES, *(f'{x}_upright' for x in _closed_form.UPRIGHT)])
def test_each_function_computes_what_the_formulation_does(name, rng):
    upright = name.endswith('_upright')
    quantity = QUANTITIES[name.removesuffix('_upright')]
    if quantity.name == 'regressor':
        quantity = TILTED_REGRESSOR
    constants = rng.normal(size=len(CONSTANTS))
    constants[CONSTANTS.index('izz1')] += 1e3  # for qdd: M is regular
    if upright:
        constants[[CONSTANTS.index(x) for x in ('hx1', 'hy1', 'up_x', 'up_y')]] = 0.0
    angles, *rest = rng.normal(size=(1 + len(quantity.inputs), 7))
    out = [None] * _closed_form.SIZES[quantity.name]
    getattr(_closed_form, name)(np.sin(angles).tolist(), np.cos(angles).tolist(),
                                *(x.tolist() for x in rest), tuple(constants.tolist()), out)
    formulation = formulate(np.sin(angles), np.cos(angles), dict(zip(CONSTANTS, constants)))
    expected = quantity.compute(formulation, *rest)
    expected = expected if isinstance(expected, tuple) else (expected,)
    expected = np.concatenate([np.ravel(part) for part in expected])
    np.testing.assert_allclose(out, expected, rtol=1e-9, atol=1e-9)


def test_regenerated_text_is_the_same():
    pytest.importorskip('casadi', reason='needed to generate: pip install casadi')
    from baxter_dynamics_ros.closed_form.module import module_text
    with open(_closed_form.__file__, encoding='utf-8') as file:
        assert file.read() == module_text(), (
            'model/_closed_form.py is out of date: run python -m baxter_dynamics_ros.closed_form')


def test_command_writes_the_whole_module(tmp_path):
    pytest.importorskip('casadi', reason='needed to generate: pip install casadi')
    from baxter_dynamics_ros.closed_form.module import write_module
    path = tmp_path / 'module.py'
    path.write_text('old')
    write_module(path)
    with open(_closed_form.__file__, encoding='utf-8') as file:
        assert path.read_text() == file.read()
    assert list(tmp_path.iterdir()) == [path]


def test_head_says_how_it_is_generated():
    assert 'python -m baxter_dynamics_ros.closed_form' in _closed_form.__doc__

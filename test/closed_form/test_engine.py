"""The engines of BaxterArm: the generated module in Python, NumPy's blocks and numba."""

import copy
import importlib.util
import os
import pickle
import subprocess
import sys

from baxter_dynamics_ros import ArgumentError, BaxterArm
from baxter_dynamics_ros.model import closed_form
from baxter_dynamics_ros.model.parameters import ArmParameters, paper_parameters
import numpy as np
import pytest

EXACT = {'rtol': 0.0, 'atol': 1e-12}
# Quantity -> how many of q, qd, qdd it takes.
ARGUMENTS = {
    'mass_matrix': 1, 'gravity': 1, 'christoffel_symbols': 1, 'coriolis_matrix': 2,
    'coriolis_torque': 2, 'terms': 2, 'torque_terms': 2, 'momentum_terms': 2,
    'inverse_dynamics': 3, 'forward_dynamics': 3, 'regressor': 3, 'inverse_dynamics_gradient': 3,
}
needs_numba = pytest.mark.skipif(importlib.util.find_spec('numba') is None,
                                 reason='numba is not installed: pip install numba')


def call(arm, name, states):
    result = getattr(arm, name)(*states[:ARGUMENTS[name]])
    return result if isinstance(result, tuple) else (result,)


def assert_same(left, right, **tolerance):
    for x, y in zip(left, right, strict=True):
        assert x.shape == y.shape
        np.testing.assert_allclose(x, y, **(tolerance or EXACT))


@pytest.mark.parametrize('name', ARGUMENTS)
def test_one_state_and_many_agree(arm, random_states, name):
    states = random_states(6)
    many = call(arm, name, states)
    tight = {'rtol': 1e-10, 'atol': 1e-12}  # qdd is of the order of 1e4
    for i in range(6):
        assert_same(call(arm, name, [x[i] for x in states]), [x[i] for x in many], **tight)
    folded = call(arm, name, [x.reshape(3, 2, 7) for x in states])
    assert_same([x.reshape(y.shape) for x, y in zip(folded, many)], many, rtol=0, atol=0)


@pytest.mark.parametrize('n', [0, 1, closed_form._BLOCK - 1, closed_form._BLOCK,
                               closed_form._BLOCK + 1, 2 * closed_form._BLOCK + 5])
def test_blocks(n, random_states):
    q, qd, qdd = random_states(n)
    arm = BaxterArm()
    tau = arm.inverse_dynamics(q, qd, qdd)
    assert tau.shape == (n, 7)
    np.testing.assert_allclose(tau, arm.composite.inverse_dynamics(q, qd, qdd), **EXACT)


@pytest.mark.parametrize('shape', [(0, 7), (3, 0, 7), (0, 3, 7)])
@pytest.mark.parametrize('name', ARGUMENTS)
def test_no_states(name, shape):
    for part in call(BaxterArm(), name, [np.empty(shape)] * 3):
        assert part.shape[:len(shape) - 1] == shape[:-1]
        assert part.size == 0


@pytest.mark.parametrize('gravity', [(1.3, 0.0, -9.4), (0.0, -1.3, -9.4)])
def test_gravity_along_no_more_than_one_axis_of_the_base(gravity, random_states):
    arm = BaxterArm(gravity=gravity)
    q, qd, qdd = random_states(20)
    np.testing.assert_allclose(arm.gravity(q), arm.composite.gravity(q), **EXACT)
    tau = arm.composite.inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(arm.inverse_dynamics(q, qd, qdd), tau, **EXACT)
    np.testing.assert_allclose(arm.regressor(q, qd, qdd) @ arm.base_parameters, tau, **EXACT)


def test_the_rounding_of_a_mount_tilts_nothing():
    half, back = (np.array([[1, 0, 0, 0], [0, np.cos(x), -np.sin(x), 0],
                            [0, np.sin(x), np.cos(x), 0], [0, 0, 0, 1]]) for x in (0.5, -0.5))
    mount = half @ back @ half @ back
    assert (mount[:3, :3].T @ [0.0, 0.0, -9.81])[1] != 0.0
    assert BaxterArm(mount=mount).base_parameters.shape == (43,)
    assert BaxterArm(gravity=(1e-9, 0.0, -9.81)).base_parameters.shape == (45,)


@pytest.mark.parametrize('value', [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize('name', ARGUMENTS)
def test_what_is_not_finite_is_refused_in_any_argument(name, value):
    for bad in range(ARGUMENTS[name]):
        states = np.zeros((3, 7))
        states[bad, 3] = value
        with pytest.raises(ArgumentError, match='finite'):
            call(BaxterArm(), name, states)


@pytest.mark.parametrize('again', [copy.copy, copy.deepcopy,
                                   lambda arm: pickle.loads(pickle.dumps(arm))])
def test_a_copy_is_the_same_arm(again, arm, random_states):
    q, qd, qdd = random_states(3)
    tau = arm.inverse_dynamics(q, qd, qdd)
    other = again(arm)
    np.testing.assert_array_equal(other.inverse_dynamics(q, qd, qdd), tau)
    np.testing.assert_array_equal(other.forward_kinematics(q), arm.forward_kinematics(q))
    assert not other.base_parameters.flags.writeable


def test_large_batches_of_poses():
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (4097, 7))
    arm = BaxterArm()
    np.testing.assert_array_equal(arm.forward_kinematics(q)[4090:],
                                  arm.forward_kinematics(q[4090:]))
    np.testing.assert_array_equal(arm.jacobian(q)[4090:], arm.jacobian(q[4090:]))


def test_sine_and_cosine_by_the_half_angle(rng):
    x = np.concatenate([rng.uniform(-10, 10, 7000), np.pi * np.arange(-8, 9) / 2, [1e9, -0.0]])
    sine, cosine = np.empty((2, len(x)))
    closed_form._sine_and_cosine(x, sine, cosine)
    np.testing.assert_allclose(sine, np.sin(x), rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(cosine, np.cos(x), rtol=0.0, atol=1e-15)


def test_christoffel_symbols_make_the_coriolis_matrix(arm, random_states):
    q, qd, _ = random_states(50)
    h = arm.christoffel_symbols(q)
    np.testing.assert_array_equal(h, h.swapaxes(-1, -2))
    np.testing.assert_allclose((h @ qd[:, None, :, None])[..., 0], arm.coriolis_matrix(q, qd),
                               **EXACT)


def test_christoffel_symbols_are_those_of_the_mass_matrix(arm, random_states):
    q, _, _ = random_states(20)
    step = 1e-3
    slope = np.stack([(8 * (arm.mass_matrix(q + d) - arm.mass_matrix(q - d))
                       - (arm.mass_matrix(q + 2 * d) - arm.mass_matrix(q - 2 * d))) / (12 * step)
                      for d in step * np.eye(7)], -1)  # dM_ik/dq_m
    expected = (slope + slope.swapaxes(-1, -2) - np.moveaxis(slope, -1, -3)) / 2
    np.testing.assert_allclose(arm.christoffel_symbols(q), expected, rtol=0.0, atol=1e-9)


def test_torque_terms_are_the_parts_of_the_torque(arm, random_states):
    q, qd, qdd = random_states(50)
    mass, coriolis, gravity = arm.torque_terms(q, qd)
    np.testing.assert_array_equal(mass, arm.mass_matrix(q))
    np.testing.assert_allclose(coriolis, arm.coriolis_torque(q, qd), **EXACT)
    np.testing.assert_allclose((mass @ qdd[..., None])[..., 0] + coriolis + gravity,
                               arm.inverse_dynamics(q, qd, qdd), **EXACT)


def test_momentum_terms(arm, random_states):
    q, qd, _ = random_states(50)
    momentum, transposed, gravity = arm.momentum_terms(q, qd)
    mass, coriolis, _ = arm.terms(q, qd)
    np.testing.assert_allclose(momentum, (mass @ qd[..., None])[..., 0], **EXACT)
    np.testing.assert_allclose(transposed, (coriolis.swapaxes(-1, -2) @ qd[..., None])[..., 0],
                               **EXACT)
    np.testing.assert_allclose(gravity, arm.gravity(q), **EXACT)


def test_gradient_by_velocity_is_twice_the_coriolis_matrix(arm, random_states):
    q, qd, qdd = random_states(50)
    _, by_qd = arm.inverse_dynamics_gradient(q, qd, qdd)
    np.testing.assert_allclose(by_qd, 2 * arm.coriolis_matrix(q, qd), **EXACT)


def test_the_printed_offset_needs_no_other_code(random_states):
    q, qd, qdd = random_states(20)
    printed = BaxterArm(parameters=paper_parameters(()))
    np.testing.assert_allclose(printed.inverse_dynamics(q, qd, qdd),
                               printed.composite.inverse_dynamics(q, qd, qdd), **EXACT)


@pytest.mark.parametrize('name, link, value', [('alpha', 2, 0.3), ('a', 1, 0.02), ('d', 3, -0.1)])
def test_arms_of_another_build_are_refused(name, link, value):
    paper = paper_parameters()
    changed = {key: getattr(paper, key).copy() for key in
               ('d', 'a', 'alpha', 'mass', 'center_of_mass', 'inertia')}
    changed[name][link] = value
    with pytest.raises(ArgumentError, match="Baxter's build"):
        BaxterArm(parameters=ArmParameters(**changed))


def test_lengths_and_the_last_frame_are_data(random_states):
    q, qd, qdd = random_states(20)
    paper = paper_parameters()
    changed = {key: getattr(paper, key).copy() for key in
               ('d', 'a', 'alpha', 'mass', 'center_of_mass', 'inertia')}
    changed['a'] *= 1.3
    changed['d'] *= 0.8
    changed['a'][6], changed['alpha'][6] = 0.05, 0.4
    arm = BaxterArm(parameters=ArmParameters(**changed))
    np.testing.assert_allclose(arm.inverse_dynamics(q, qd, qdd),
                               arm.composite.inverse_dynamics(q, qd, qdd), **EXACT)


# To compile takes seconds each; the rest is of the same kind, and more of it is in the benchmark.
@needs_numba
@pytest.mark.parametrize('arm, name', [
    ({}, 'gravity'), ({'gravity': (1.3, -2.1, -9.4)}, 'inverse_dynamics')], indirect=['arm'])
def test_numba_computes_the_same(arm, random_states, name):
    python, numba = (
        BaxterArm(payload=arm.payload, gravity=arm.gravity_vector, mount=arm.mount, engine=engine)
        for engine in ('python', 'numba'))
    states = random_states(1030)  # more than a block
    loose = {'rtol': 1e-10, 'atol': 1e-12}
    assert_same(call(numba, name, states), call(python, name, states), **loose)
    one = [x[0] for x in states]
    assert_same(call(numba, name, one), call(python, name, one), **loose)


@needs_numba
@pytest.mark.filterwarnings('error')
def test_numba_compiles_once_whatever_the_arrays(random_states):
    from baxter_dynamics_ros import compiled
    arm = BaxterArm(engine='numba')
    assert arm.gravity(np.empty((0, 7))).shape == (0, 7)
    q, _, _ = random_states(10)
    expected = arm.gravity(q)
    fixed = q.copy()
    fixed.flags.writeable = False
    for same in (q[::-1][::-1], np.asfortranarray(q), fixed, np.broadcast_to(q, (1, 10, 7))):
        np.testing.assert_array_equal(arm.gravity(same).reshape(10, 7), expected)
    np.testing.assert_allclose(arm.gravity(fixed[0]), expected[0], rtol=0.0, atol=1e-14)
    for function in (compiled.MODULE.gravity_upright_row, compiled.MODULE.gravity_upright_rows):
        assert len(function.signatures) == 1


@needs_numba
def test_numbas_sine_and_cosine(rng):
    from baxter_dynamics_ros import compiled
    x = np.concatenate([rng.uniform(-10, 10, 10000), rng.uniform(-1e5, 1e5, 10000),
                        np.pi * np.arange(-40, 41) / 4, [1e5, 3e7, -1e300, 0.0, 5e-324]])
    sine, cosine = np.empty((2, len(x)))
    compiled.sines_and_cosines(x, sine, cosine)
    np.testing.assert_allclose(sine, np.sin(x), rtol=0.0, atol=2.5e-16)
    np.testing.assert_allclose(cosine, np.cos(x), rtol=0.0, atol=2.5e-16)


def loaded_by(engine, **environment):
    """Return whether numba is loaded by a fresh process that makes an arm and uses it."""
    code = ('import sys; from baxter_dynamics_ros import BaxterArm; '
            f"BaxterArm({engine}).gravity([0.0] * 7); print('numba' in sys.modules)")
    answer = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True,
                            env={**os.environ, **environment}, timeout=120, check=True)
    return answer.stdout.strip() == 'True'


@needs_numba
@pytest.mark.parametrize('engine, variable, loads', [
    ('', 'auto', True), ('', 'numba', True), ('', 'python', False), ('engine="python"', 'numba',
                                                                     False)])
def test_which_engine_is_chosen(engine, variable, loads):
    assert loaded_by(engine, BAXTER_DYNAMICS_ENGINE=variable) == loads


def test_a_numba_that_does_not_load_is_done_without(tmp_path):
    (tmp_path / 'numba.py').write_text("raise ImportError('made for another NumPy')\n")

    def run(engine):
        code = f'from baxter_dynamics_ros import BaxterArm; BaxterArm({engine}).gravity([0] * 7)'
        return subprocess.run(
            [sys.executable, '-c', code], capture_output=True, text=True, timeout=60,
            env={**os.environ, 'BAXTER_DYNAMICS_ENGINE': 'auto', 'PYTHONPATH': os.pathsep.join(
                [str(tmp_path), os.environ.get('PYTHONPATH', '')])})

    answer = run('')
    assert answer.returncode == 0
    assert 'numba does not load (made for another NumPy)' in answer.stderr
    answer = run('engine="numba"')
    assert answer.returncode == 1
    assert 'ArgumentError: engine: numba does not load' in answer.stderr


@needs_numba
def test_numba_does_without_a_folder_to_keep_its_code_in():
    # numba finds no place, whoever runs this test: neither beside the source nor in a cache.
    code = ('import numba.core.caching as caching; caching.CacheImpl._locator_classes = []; '
            'from baxter_dynamics_ros import BaxterArm; '
            "print(BaxterArm(engine='numba').gravity([0.1] * 7)[1])")
    answer = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True,
                            timeout=120)
    assert answer.returncode == 0, answer.stderr
    assert float(answer.stdout) == pytest.approx(BaxterArm().gravity([0.1] * 7)[1])


def test_an_unknown_engine_is_refused(monkeypatch):
    with pytest.raises(ArgumentError, match="engine.*expected one of .*'fortran'"):
        BaxterArm(engine='fortran')
    monkeypatch.setenv('BAXTER_DYNAMICS_ENGINE', 'fortran')
    with pytest.raises(ArgumentError, match='BAXTER_DYNAMICS_ENGINE'):
        BaxterArm()

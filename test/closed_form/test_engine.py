"""The compiled and the Python engine of BaxterArm agree."""

from concurrent.futures import ThreadPoolExecutor
import copy
from dataclasses import replace
import os
import pickle
import subprocess
import sys

from baxter_dynamics_ros import ArgumentError, BaxterArm, EffortModel
from baxter_dynamics_ros.model import closed_form, lagrange_euler
from baxter_dynamics_ros.model._closed_form import FUNCTIONS
from baxter_dynamics_ros.model.paper_tables import GRAVITY
from baxter_dynamics_ros.model.parameters import paper_parameters
import numpy as np
import pytest

_compiled = pytest.importorskip(
    'baxter_dynamics_ros.model._compiled', reason='the extension is not built: pip install -e .')
EXACT = {'rtol': 0.0, 'atol': 1e-12}
ARGUMENTS = {name: 1 + len(inputs) for name, (inputs, _) in FUNCTIONS.items()}
ENGINES = ('compiled', 'python')


@pytest.fixture
def both(arm):
    """Return the arm of each case, computed by either engine."""
    return [BaxterArm(arm.payload, arm.gravity_vector, arm.mount, arm.parameters, engine)
            for engine in ENGINES]


@pytest.fixture(params=ENGINES)
def engine(request):
    return request.param


def call(arm, name, states):
    result = getattr(arm, name)(*states[:ARGUMENTS[name]])
    return result if isinstance(result, tuple) else (result,)


def assert_same(left, right, rtol=1e-10, atol=1e-12):  # qdd is of the order of 1e4
    for x, y in zip(left, right, strict=True):
        assert x.shape == y.shape
        np.testing.assert_allclose(x, y, rtol=rtol, atol=atol)


@pytest.mark.parametrize('name', ARGUMENTS)
def test_engines_agree_on_one_state_and_on_batches(both, random_states, name):
    states = random_states(600)
    compiled, python = (call(arm, name, states) for arm in both)
    assert_same(compiled, python)
    for arm in both:
        folded = call(arm, name, [x.reshape(3, 200, 7) for x in states])
        assert_same([x.reshape(y.shape) for x, y in zip(folded, compiled)], compiled)
        for i in (0, 599):
            assert_same(call(arm, name, [x[i] for x in states]), [x[i] for x in compiled])


@pytest.mark.parametrize('n', [0, 1, 2, 15, 16, 17, 512, 513, closed_form._BLOCK + 5])
def test_batches_of_any_size_on_each_instruction_set(n, random_states):
    states, arm = random_states(n), BaxterArm(engine='python')
    for target in _compiled.TARGETS:
        function = _compiled.function(
            'inverse_dynamics', ('q', 'qd', 'qdd'), [(7,)], arm.closed_form_parameters,
            closed_form.finite_batches, target)
        np.testing.assert_allclose(function(*states), arm.inverse_dynamics(*states), **EXACT)


@pytest.mark.parametrize('shape', [(0, 7), (3, 0, 7)])
def test_empty_batches(shape, engine):
    for name in ARGUMENTS:
        for part in call(BaxterArm(engine=engine), name, [np.empty(shape)] * 3):
            assert part.shape[:len(shape) - 1] == shape[:-1] and part.size == 0


@pytest.mark.parametrize('value', [np.nan, np.inf, -np.inf])
def test_error_names_the_index_of_a_non_finite_value(value, engine):
    arm = BaxterArm(engine=engine)
    cases = [(name, bad, argument) for name, (vectors, _) in FUNCTIONS.items()
             for bad, argument in enumerate(('q', *vectors))]
    for name, bad, argument in cases:
        for shape, place in (((7,), (3,)), ((1, 7), (0, 3)), ((2000, 7), (1717, 3))):
            states = np.zeros((3, *shape))
            states[(bad, *place)] = value
            with pytest.raises(ArgumentError) as caught:
                call(arm, name, states)
            assert str(caught.value) == (
                f'{argument}: expected finite values, got {value} at index {place}')


def test_arrays_of_any_kind(random_states, engine):
    arm = BaxterArm(engine=engine)
    q, qd, qdd = random_states(20)
    expected = arm.inverse_dynamics(q, qd, qdd)
    unaligned = np.frombuffer(b'x' + q.tobytes(), offset=1).reshape(q.shape)
    fixed = q.copy()
    fixed.flags.writeable = False
    for same in (unaligned, fixed, np.asfortranarray(q), q[::-1].copy()[::-1], q.astype('>f8'),
                 q.tolist(), np.repeat(q, 2, axis=1)[:, ::2]):
        np.testing.assert_allclose(arm.inverse_dynamics(same, qd, qdd), expected, **EXACT)
    assert_same([arm.gravity(q.astype(np.float32))], [arm.gravity(q)], atol=1e-5)
    assert_same([arm.gravity(np.ones(7, int))], [arm.gravity(np.ones(7))])
    np.testing.assert_allclose(arm.inverse_dynamics(q, q, q), arm.inverse_dynamics(
        q, q.copy(), q.copy()), **EXACT)
    np.testing.assert_allclose(arm.coriolis_torque(q[:, None], qd[0]), arm.coriolis_torque(
        q[:, None], np.broadcast_to(qd[0], (20, 1, 7))), **EXACT)
    np.testing.assert_array_equal(fixed, q)


def test_large_and_tiny_angles(rng, engine):
    x = np.concatenate([rng.uniform(-b, b, 7000) for b in (10, 1e4, 1e8, 1e12)] + [
        np.pi * np.arange(-21, 21) / 4, [1e300, -1e300, 1e8, 5e-324, 0.0, -0.0, 1e-9]])
    x = x.reshape(-1, 7)
    jacobian = BaxterArm(engine=engine).jacobian(x)
    # Joint 2's axis is (-sin q1, cos q1, 0).
    np.testing.assert_allclose(jacobian[:, 3, 1], -np.sin(x[:, 0]), rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(jacobian[:, 4, 1], np.cos(x[:, 0]), rtol=0.0, atol=1e-15)


def test_threads_share_an_arm(random_states):
    arm, states = BaxterArm(engine='compiled'), random_states(20_000)
    expected = arm.inverse_dynamics(*states)
    with ThreadPoolExecutor(4) as pool:
        for result in pool.map(lambda _: arm.inverse_dynamics(*states), range(16)):
            np.testing.assert_array_equal(result, expected)


def test_no_reference_leaks():
    arm = BaxterArm(engine='compiled')
    states = np.zeros((3, 7))
    broken = states.copy()
    broken[2, 0] = np.nan
    before = sys.getrefcount(states), sys.getrefcount(closed_form.finite_batches)
    for _ in range(200):
        arm.inverse_dynamics(*states)
        with pytest.raises(ArgumentError):
            arm.inverse_dynamics(*broken)
        BaxterArm(engine='compiled')
    after = sys.getrefcount(states), sys.getrefcount(closed_form.finite_batches)
    assert abs(after[0] - before[0]) + abs(after[1] - before[1]) < 20


def test_rounding_of_the_mount_is_ignored():
    half, back = (np.array([[1, 0, 0, 0], [0, np.cos(x), -np.sin(x), 0],
                            [0, np.sin(x), np.cos(x), 0], [0, 0, 0, 1]]) for x in (0.5, -0.5))
    mount = half @ back @ half @ back
    assert (mount[:3, :3].T @ [0.0, 0.0, -9.81])[1] != 0.0
    assert BaxterArm(mount=mount).base_parameters.shape == (43,)
    assert BaxterArm(gravity=(1e-9, 0.0, -9.81)).base_parameters.shape == (45,)


@pytest.mark.parametrize('again', [copy.copy, copy.deepcopy,
                                   lambda arm: pickle.loads(pickle.dumps(arm))])
def test_copies_and_pickles(again, both, random_states):
    for arm in both:
        states, other = random_states(3), again(arm)
        assert other.engine == arm.engine
        np.testing.assert_array_equal(other.inverse_dynamics(*states),
                                      arm.inverse_dynamics(*states))
        for array in (other.base_parameters, other.parameters.mass, again(EffortModel()).bias):
            assert not array.flags.writeable


def test_momentum_and_torque_terms(arm, random_states):
    q, qd, _ = random_states(50)
    mass, coriolis, gravity = arm.terms(q, qd)
    momentum, torque, transposed = ((matrix @ qd[..., None])[..., 0] for matrix in (
        mass, coriolis, coriolis.swapaxes(-1, -2)))
    assert_same(arm.momentum_terms(q, qd), (momentum, transposed, gravity))
    assert_same(arm.torque_terms(q, qd), (mass, torque, gravity))
    assert_same([arm.coriolis_torque(q, qd)], [torque])


def test_parameters_as_printed(random_states, engine):
    states, printed = random_states(20), BaxterArm(parameters=paper_parameters(()), engine=engine)
    expected = lagrange_euler.inverse_dynamics(printed.parameters, *states, GRAVITY)
    np.testing.assert_allclose(printed.inverse_dynamics(*states), expected, **EXACT)
    np.testing.assert_allclose(printed.inverse_dynamics(*(x[0] for x in states)), expected[0],
                               **EXACT)


@pytest.mark.parametrize('name, link, value', [('alpha', 2, 0.3), ('a', 1, 0.02), ('d', 3, -0.1)])
def test_other_kinematic_structures_are_refused(name, link, value):
    changed = getattr(paper_parameters(), name).copy()
    changed[link] = value
    with pytest.raises(ArgumentError, match="Baxter's kinematic structure"):
        BaxterArm(parameters=replace(paper_parameters(), **{name: changed}))


@pytest.mark.parametrize('engine, variable, chosen', [
    ('auto', 'auto', 'compiled'), ('auto', '', 'compiled'), ('auto', 'python', 'python'),
    ('python', 'compiled', 'python'), ('compiled', 'python', 'compiled')])
def test_engine_selection(engine, variable, chosen, monkeypatch):
    monkeypatch.setenv('BAXTER_DYNAMICS_ENGINE', variable)
    assert BaxterArm(engine=engine).engine == chosen


MISSING = 'sys.modules["baxter_dynamics_ros.model._compiled"] = None\n'
BROKEN = """
from importlib.machinery import ModuleSpec
class Finder:
    def find_spec(self, name, path=None, target=None):
        return ModuleSpec(name, self) if name.endswith('._compiled') else None
    def create_module(self, spec):
        raise ImportError('built for another Python')
    def exec_module(self, module): pass
sys.meta_path.insert(0, Finder())
"""


@pytest.mark.parametrize('condition, warned', [(MISSING, False), (BROKEN, True)],
                         ids=['missing', 'broken'])
def test_falls_back_to_python_without_the_extension(condition, warned):
    code = (f'import sys\n{condition}from baxter_dynamics_ros import BaxterArm\n'
            'print(BaxterArm().engine)\nBaxterArm(engine="compiled")')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, timeout=60,
                          env={**os.environ, 'BAXTER_DYNAMICS_ENGINE': ''})
    assert done.stdout.strip() == 'python'
    assert ('UserWarning: engine: the compiled extension' in done.stderr) == warned
    assert 'ArgumentError: engine: the compiled extension does not load' in done.stderr


def test_unknown_engine_is_refused(monkeypatch):
    with pytest.raises(ArgumentError, match="engine.*expected one of .*'fortran'"):
        BaxterArm(engine='fortran')
    monkeypatch.setenv('BAXTER_DYNAMICS_ENGINE', 'fortran')
    with pytest.raises(ArgumentError, match='BAXTER_DYNAMICS_ENGINE'):
        BaxterArm()

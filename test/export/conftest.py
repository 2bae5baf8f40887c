"""What the tests of exports share: files of an arm, states, and the specification's answers."""

from functools import lru_cache
from importlib import import_module
from types import SimpleNamespace

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.export.functions import derive, SYMBOLS
from baxter_dynamics_ros.model import lagrange_euler
from baxter_dynamics_ros.model.base_parameters import base_parameters
from baxter_dynamics_ros.model.composite import CompositeDynamics
import numpy as np
import pytest

_ANSWERS = {}
EXACT = {'rtol': 0.0, 'atol': 1e-11}


@pytest.fixture
def functions():
    """Return a function that derives an arm's functions, of all quantities by default."""
    pytest.importorskip('casadi', reason='needed to derive: pip install casadi')
    return lambda arm, symbols=tuple(SYMBOLS): [
        _derive(symbol, arm.dynamics.upright) for symbol in symbols]


@pytest.fixture
def export(tmp_path, functions):
    """Return a function that writes an arm's files to tmp_path: their paths, by name."""
    def write(target, arm, *symbols):
        module = import_module(f'baxter_dynamics_ros.export.{target}')
        files = module.files(functions(arm, *symbols), arm, 'baxter_dynamics')
        for name, text in files.items():
            (tmp_path / name).write_text(text, encoding='utf-8')
        return {name: tmp_path / name for name in files}

    return write


@lru_cache(maxsize=None)
def _derive(symbol, upright):
    """Derive a function once for all arms: they differ by numbers, and by this."""
    arm = BaxterArm(gravity=(0.0, 0.0, -9.81) if upright else (1.0, 2.0, -9.0))
    (function,) = derive(arm, (symbol,))
    return function


@pytest.fixture
def states(random_states):
    """Return 200 states by name, q, qd, qdd and tau, each (200, 7)."""
    q, qd, qdd = random_states(200)
    return {'q': q, 'qd': qd, 'qdd': qdd, 'tau': 10.0 * qdd[::-1]}


@pytest.fixture
def specification(states):
    """Return a function that makes the specification's answers for an arm at the states."""
    def answers(arm):
        # Slow to make, and the same for every target.
        numbers = (arm.payload, arm.gravity_vector.tobytes(), arm.mount.tobytes(),
                   states['q'].tobytes())
        if numbers not in _ANSWERS:
            _ANSWERS[numbers] = Specification(arm, states)
        return _ANSWERS[numbers]

    return answers


class Specification:
    """The equations of the paper, for one arm at given states."""

    def __init__(self, arm, states):
        self._arm = arm
        self._q, self._qd, self._qdd, self._tau = states.values()
        pseudo_inertia = arm.parameters.pseudo_inertia.copy()
        pseudo_inertia[6] += arm.payload.pseudo_inertia
        g = arm.mount[:3, :3].T @ arm.gravity_vector
        p = SimpleNamespace(**{**vars(arm.parameters), 'pseudo_inertia': pseudo_inertia})
        self._composite = CompositeDynamics(arm.parameters, pseudo_inertia, g)
        self.mass_matrix = lagrange_euler.mass_matrix(p, self._q)
        self.christoffel_symbols = lagrange_euler.christoffel(p, self._q)
        self.coriolis_matrix = np.einsum('nikm,nm->nik', self.christoffel_symbols, self._qd)
        self.coriolis_torque = _times(self.coriolis_matrix, self._qd)
        self.gravity = lagrange_euler.gravity(p, self._q, g)
        self.terms = self.mass_matrix, self.coriolis_matrix, self.gravity
        self.inverse_dynamics = self._torque(self._qdd)

    def check(self, quantity, *results):
        """Assert that the results, one array (200, ...) for each output, are a quantity's."""
        if quantity == 'forward_dynamics':
            # What M^-1 makes of rounding is not the equations' fault: judge by the torque.
            results, expected = [self._torque(*results)], self._tau
        elif quantity == 'regressor':
            results, expected = self._torques_of_random_links(*results)
        elif quantity == 'inverse_dynamics_gradient':
            expected = self._derivative(), 2 * self.coriolis_matrix  # eq. (7) is quadratic in qd
        else:
            expected = getattr(self, quantity)
        expected = expected if isinstance(expected, tuple) else (expected,)
        assert len(results) == len(expected)
        for result, value in zip(results, expected):
            assert result.shape == value.shape
            np.testing.assert_allclose(result, value, **EXACT)

    def _torque(self, qdd):
        return _times(self.mass_matrix, qdd) + self.coriolis_torque + self.gravity

    def _torques_of_random_links(self, y):
        """Return Y phi of 50 arms with links of their own, and their tau: they tell all of Y."""
        random = np.random.default_rng(1)
        half = random.normal(size=(50, 7, 4, 4))
        links = half + half.swapaxes(-1, -2)
        phi = base_parameters(self._arm.parameters, links)[:, :y.shape[-1]]
        full = self._composite.regressor(self._q, self._qd, self._qdd)
        return [np.einsum('nib,rb->nir', y, phi)], np.einsum('niljk,rljk->nir', full, links)

    def _derivative(self):
        """Return d tau/dq: tau is a trigonometric polynomial of q_k, of degree 2 by eq. (5)."""
        result = np.zeros(self.mass_matrix.shape)
        step = 2 * np.pi / 5  # five points determine it, and its derivative, exactly
        for k, direction in enumerate(np.eye(7)):
            for j in range(1, 5):
                tau = self._composite.inverse_dynamics(
                    self._q + j * step * direction, self._qd, self._qdd)
                result[:, :, k] -= (-1) ** j / (2 * np.sin(j * step / 2)) * tau
        return result


def _times(matrices, vectors):
    return np.einsum('nik,nk->ni', matrices, vectors)

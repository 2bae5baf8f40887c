"""The model against the paper's equations, term by term, and conventions of the documentation."""

from dataclasses import replace
from types import SimpleNamespace

from baxter_dynamics_ros import BaxterArm, mount
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model import lagrange_euler
from baxter_dynamics_ros.model.joints import gravity_in_base
from baxter_dynamics_ros.model.parameters import INERTIA_AT_ORIGIN, paper_parameters
import numpy as np
import pytest

EXACT = {'rtol': 0.0, 'atol': 1e-12}


@pytest.fixture
def parameters(arm):
    """Return the parameters of the arm, with the payload added to the last link."""
    pseudo_inertia = arm.parameters.pseudo_inertia.copy()
    pseudo_inertia[6] += arm.payload.pseudo_inertia
    return SimpleNamespace(**{**vars(arm.parameters), 'pseudo_inertia': pseudo_inertia})


def test_each_equation(arm, parameters, random_states):
    q, qd, qdd = random_states(50)
    g = arm.mount[:3, :3].T @ arm.gravity_vector  # in frame {0}
    symbols = lagrange_euler.christoffel(parameters, q)
    coriolis = np.einsum('nikm,nm->nik', symbols, qd)
    mass = lagrange_euler.mass_matrix(parameters, q)
    gravity = lagrange_euler.gravity(parameters, q, g)
    tau = np.einsum('nik,nk->ni', mass, qdd) + np.einsum('nik,nk->ni', coriolis, qd) + gravity
    for result, expected in (
            (arm.forward_kinematics(q),
             arm.mount @ lagrange_euler.transform(parameters, 0, 7, q)),  # eq. (2)
            (arm.inverse_dynamics(q, qd, qdd), tau),  # eq. (5)
            (arm.mass_matrix(q), mass),  # eq. (6)
            (arm.christoffel_symbols(q), symbols),  # eq. (7)
            (arm.coriolis_matrix(q, qd), coriolis),
            (arm.gravity(q), gravity)):  # eq. (8)
        np.testing.assert_allclose(result, expected, **EXACT)
    state = q[0], qd[0], qdd[0]
    np.testing.assert_allclose(lagrange_euler.inverse_dynamics(parameters, *state, g), tau[0],
                               **EXACT)


def test_h_of_eq_7_is_the_christoffel_symbol_of_m(parameters, random_states):
    # h_ikm = (dM_ik/dq_m + dM_im/dq_k - dM_km/dq_i) / 2, with fourth-order differences of eq. (6).
    q, step = random_states(3)[0], 1e-3
    at = [lagrange_euler.mass_matrix(parameters, q[:, None] + n * step * np.eye(7))
          for n in (-2, -1, 1, 2)]
    derivative = np.moveaxis((at[0] - 8 * at[1] + 8 * at[2] - at[3]) / (12 * step), 1, -1)
    expected = (derivative + np.einsum('...imk->...ikm', derivative)
                - np.einsum('...kmi->...ikm', derivative)) / 2
    np.testing.assert_allclose(lagrange_euler.christoffel(parameters, q), expected,
                               rtol=0.0, atol=1e-10)


def test_leading_axes_broadcast(random_states):
    arm = BaxterArm()
    q, qd, qdd = random_states(5)
    result = arm.inverse_dynamics(q[:, None], qd[:3], qdd[0])  # (5, 1, 7), (3, 7), (7,)
    assert result.shape == (5, 3, 7)
    for i, k in np.ndindex(5, 3):
        np.testing.assert_allclose(result[i, k], arm.inverse_dynamics(q[i], qd[k], qdd[0]),
                                   **EXACT)


def test_other_lengths_and_angles(random_states, rng):
    q, parameters = random_states(50)[0], paper_parameters()
    nonzero = np.array([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0])  # as the closed form requires
    arm = BaxterArm(mount=mount('left'), parameters=replace(
        parameters, a=rng.uniform(-0.3, 0.3, 7) * nonzero,
        d=rng.uniform(-0.3, 0.3, 7) * nonzero,
        alpha=parameters.alpha + [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6],
        corrections=frozenset({INERTIA_AT_ORIGIN})))  # and theta_2 = q_2
    expected = arm.mount @ lagrange_euler.transform(arm.parameters, 0, 7, q)
    np.testing.assert_allclose(arm.forward_kinematics(q), expected, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize('side', ['right', 'left'])
def test_positive_directions(side):
    """As docs/model.md describes them, with all joints at zero."""
    jacobian = BaxterArm(mount=mount(side)).jacobian(np.zeros(7))
    _, left, up = jacobian[:3]
    assert left[0] > 0.5 and abs(up[0]) < 1e-12
    assert all(up[joint] < -0.2 for joint in (1, 3, 5))
    outwards = BaxterArm(mount=mount(side)).forward_kinematics(np.zeros(7))[:3, 2]
    np.testing.assert_allclose(jacobian[3:, [2, 4, 6]].T, [outwards] * 3, atol=1e-12)


def test_directions_of_roll_and_pitch():
    x, y, z = gravity_in_base((0.0, 0.0, -9.81), 0.1, 0.0)
    assert x == 0.0 and y < 0.0 and z == pytest.approx(-9.81 * np.cos(0.1))
    x, y, z = gravity_in_base((0.0, 0.0, -9.81), 0.0, 0.1)
    assert x > 0.0 and y == 0.0


def test_pitch_follows_roll_about_fixed_axes(rng):
    gravity = rng.normal(size=3)
    for roll, pitch in ((0.3, -0.2), (-1.2, 0.7), (np.pi, 0.0), (0.0, 3.0), (0.0, 0.0)):
        expected = gravity_in_base(gravity_in_base(gravity, 0.0, pitch), roll, 0.0)
        found = gravity_in_base(gravity, roll, pitch)
        np.testing.assert_allclose(found, expected, atol=1e-14)
        assert found @ found == pytest.approx(gravity @ gravity, rel=1e-14)


def test_settings_base_and_gravity_agree():
    tilted = PredictorSettings.from_parameters({'base.roll': 0.2, 'base.pitch': -0.1})
    turned = PredictorSettings(gravity=tuple(gravity_in_base((0.0, 0.0, -9.81), 0.2, -0.1)))
    q = np.linspace(-1.0, 1.0, 7)
    np.testing.assert_array_equal(tilted.model.arm.gravity(q), turned.model.arm.gravity(q))
    level = PredictorSettings().model.arm.gravity(q)
    assert np.abs(tilted.model.arm.gravity(q) - level).max() > 1.0

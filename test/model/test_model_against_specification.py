"""The fast form of the equations against the paper's form, term by term, and its batches."""

from types import SimpleNamespace

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.model import lagrange_euler
import numpy as np
import pytest

EXACT = {'rtol': 0.0, 'atol': 1e-12}
BLOCK = 4096  # states that BaxterArm computes at a time


@pytest.fixture
def parameters(arm):
    """Return the arm's parameters with its payload added, as the specification takes them."""
    pseudo_inertia = arm.parameters.pseudo_inertia.copy()
    pseudo_inertia[6] += arm.payload.pseudo_inertia
    return SimpleNamespace(**{**vars(arm.parameters), 'pseudo_inertia': pseudo_inertia})


@pytest.fixture
def g(arm):
    """Return the arm's gravity vector in frame {0}."""
    return arm.mount[:3, :3].T @ arm.gravity_vector


@pytest.fixture
def states(random_states):
    return random_states(150)


def test_mass_matrix_is_eq_6(arm, parameters, states):
    q, _, _ = states
    np.testing.assert_allclose(arm.mass_matrix(q), lagrange_euler.mass_matrix(parameters, q),
                               **EXACT)


def test_coriolis_matrix_is_eq_7(arm, parameters, states):
    q, qd, _ = states
    np.testing.assert_allclose(arm.coriolis_matrix(q, qd),
                               lagrange_euler.coriolis_matrix(parameters, q, qd), **EXACT)


def test_gravity_is_eq_8(arm, parameters, g, states):
    q, _, _ = states
    np.testing.assert_allclose(arm.gravity(q), lagrange_euler.gravity(parameters, q, g), **EXACT)


def test_inverse_dynamics_is_eq_5(arm, parameters, g, states):
    np.testing.assert_allclose(arm.inverse_dynamics(*states),
                               lagrange_euler.inverse_dynamics(parameters, *states, g), **EXACT)


def test_forward_kinematics_is_eq_2(arm, parameters, states):
    q, _, _ = states
    np.testing.assert_allclose(arm.forward_kinematics(q),
                               arm.mount @ lagrange_euler.transform(parameters, 0, 7, q), **EXACT)


def test_every_christoffel_symbol(arm, parameters, states):
    # C is linear in qd: with qd = e_m it is the slice h[:, :, m].
    q, _, _ = states
    symbols = np.stack([arm.coriolis_matrix(q, unit) for unit in np.eye(7)], axis=-1)
    np.testing.assert_allclose(symbols, lagrange_euler.christoffel(parameters, q), **EXACT)


def test_h_of_eq_7_is_the_christoffel_symbol_of_m(parameters, states):
    # h_ikm = (dM_ik/dq_m + dM_im/dq_k - dM_km/dq_i) / 2, with fourth-order differences of eq. (6).
    q, step = states[0][:30], 1e-3
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

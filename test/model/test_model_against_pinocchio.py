"""The model against Pinocchio with the same parameters."""

import numpy as np
import pytest

N_STATES = 2000
# Absolute, on torques up to 100 N m: a hundred units in the last place. Measured: 6e-14.
EXACT = {'rtol': 0.0, 'atol': 1e-12}


@pytest.fixture
def states(random_states):
    return random_states(N_STATES)


def test_terms(arm, reference, states):
    q, qd, _ = states
    mass, coriolis, gravity = arm.terms(q, qd)
    np.testing.assert_allclose(mass, reference.mass_matrix(q), **EXACT)
    np.testing.assert_allclose(coriolis, reference.coriolis_matrix(q, qd), **EXACT)
    np.testing.assert_allclose(gravity, reference.gravity(q), **EXACT)


def test_inverse_dynamics(arm, reference, states):
    np.testing.assert_allclose(arm.inverse_dynamics(*states), reference.inverse_dynamics(*states),
                               **EXACT)


def test_inverse_dynamics_gradient(arm, reference, states):
    by_q, by_qd = arm.inverse_dynamics_gradient(*states)
    expected_by_q, expected_by_qd = reference.inverse_dynamics_gradient(*states)
    np.testing.assert_allclose(by_q, expected_by_q, **EXACT)
    np.testing.assert_allclose(by_qd, expected_by_qd, **EXACT)


def test_forward_dynamics(arm, reference, states, rng):
    # Not absolute: M has condition numbers up to 1e4, so that rounding at 1e-16 of the torques
    # comes out at 1e-12 of the accelerations, and those are large (torques that a shoulder
    # hardly feels throw a wrist about at 1e4 rad/s^2). Hence relative to the size of qdd, state
    # by state.
    q, qd, _ = states
    tau = rng.uniform(-50.0, 50.0, q.shape)
    expected = reference.forward_dynamics(q, qd, tau)
    error = np.linalg.norm(arm.forward_dynamics(q, qd, tau) - expected, axis=-1)
    assert (error / np.linalg.norm(expected, axis=-1)).max() < 1e-11


def test_newton_euler(arm, pin, states):
    from baxter_dynamics_ros.newton_euler import NewtonEuler
    recursive = NewtonEuler(arm)
    for state in zip(*(x[:100] for x in states)):
        np.testing.assert_allclose(recursive.inverse_dynamics(*state),
                                   arm.inverse_dynamics(*state), **EXACT)

"""The model against Pinocchio and MuJoCo, which share the parameters and no dynamics code."""

import numpy as np
import pytest

# Absolute, on torques up to 100 N m: a hundred units in the last place. Measured: 6e-14.
EXACT = {'rtol': 0.0, 'atol': 1e-12}


@pytest.fixture
def states(random_states):
    return random_states(1000)


def test_pinocchio(arm, reference, states):
    q, qd, _ = states
    mass, coriolis, gravity = arm.terms(q, qd)
    np.testing.assert_allclose(mass, reference.mass_matrix(q), **EXACT)
    np.testing.assert_allclose(coriolis, reference.coriolis_matrix(q, qd), **EXACT)
    np.testing.assert_allclose(gravity, reference.gravity(q), **EXACT)
    np.testing.assert_allclose(arm.inverse_dynamics(*states), reference.inverse_dynamics(*states),
                               **EXACT)
    for ours, theirs in zip(arm.inverse_dynamics_gradient(*states),
                            reference.inverse_dynamics_gradient(*states)):
        np.testing.assert_allclose(ours, theirs, **EXACT)
    np.testing.assert_allclose(arm.forward_kinematics(q), reference.forward_kinematics(q),
                               rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(arm.jacobian(q), reference.jacobian(q), rtol=0.0, atol=1e-14)


def test_forward_dynamics_against_pinocchio(arm, reference, states, rng):
    # Relative to the size of qdd, state by state: M has condition numbers up to 1e4, and torques
    # that a shoulder hardly feels turn a wrist at 1e4 rad/s^2.
    q, qd, _ = states
    tau = rng.uniform(-50.0, 50.0, q.shape)
    expected = reference.forward_dynamics(q, qd, tau)
    error = np.linalg.norm(arm.forward_dynamics(q, qd, tau) - expected, axis=-1)
    assert (error / np.linalg.norm(expected, axis=-1)).max() < 1e-11


def test_newton_euler(arm, pin, states):
    from baxter_dynamics_ros.newton_euler import NewtonEuler
    recursive, expected = NewtonEuler(arm), arm.inverse_dynamics(*states)
    np.testing.assert_allclose(recursive.inverse_dynamics(*states), expected, **EXACT)
    one = recursive.inverse_dynamics(*(x[7] for x in states))
    np.testing.assert_allclose(one, expected[7], **EXACT)


def test_mujoco(arm, states):
    mujoco = pytest.importorskip('mujoco', reason='the physics engine: pip install mujoco')
    from mujoco_model import mjcf
    model = mujoco.MjModel.from_xml_string(mjcf(arm))
    data, expected = mujoco.MjData(model), []
    for data.qpos, data.qvel, data.qacc in zip(*states):
        mujoco.mj_inverse(model, data)
        tau, hand = data.qfrc_inverse.copy(), data.body('hand').xpos.copy()
        data.qfrc_applied = data.qacc  # numbers of qdd, as torques
        mujoco.mj_forward(model, data)
        expected.append((tau, hand, data.qacc.copy()))
        data.qfrc_applied = 0.0
    q, qd, qdd = states
    tau, hand, acceleration = (np.array(part) for part in zip(*expected))
    # Its compiler turns inertias to principal axes, by an iteration. Measured: 4e-13.
    np.testing.assert_allclose(arm.inverse_dynamics(*states), tau, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(arm.forward_kinematics(q)[:, :3, 3], hand, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(arm.forward_dynamics(q, qd, qdd), acceleration, rtol=0.0, atol=1e-6)

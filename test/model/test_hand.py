"""Pose and Jacobian of the hand against Pinocchio, the matrix equations and the hand's motion."""

from dataclasses import replace

from baxter_dynamics_ros import BaxterArm, mount
from baxter_dynamics_ros.model.lagrange_euler import transform
from baxter_dynamics_ros.model.parameters import INERTIA_AT_ORIGIN, paper_parameters
import numpy as np
import pytest

EXACT = {'rtol': 0.0, 'atol': 1e-14}
STEP = 3e-4  # of the fourth-order differences: truncation and rounding are both near 1e-11


@pytest.fixture
def q(random_states):
    return random_states(300)[0]


def rate(function, q, qd):
    """Return the derivative of a function in the direction qd."""
    def at(t):
        return function(q + t * qd)
    return (8 * (at(STEP) - at(-STEP)) - (at(2 * STEP) - at(-2 * STEP))) / (12 * STEP)


def test_pinocchio_has_the_same_pose_and_jacobian(arm, reference, q):
    np.testing.assert_allclose(arm.forward_kinematics(q), reference.forward_kinematics(q), **EXACT)
    np.testing.assert_allclose(arm.jacobian(q), reference.jacobian(q), **EXACT)


def test_other_lengths_and_angles(q, rng):
    parameters = paper_parameters()
    nonzero = np.array([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0])  # as the closed form requires
    arm = BaxterArm(mount=mount('left'), parameters=replace(
        parameters, a=rng.uniform(-0.3, 0.3, 7) * nonzero,
        d=rng.uniform(-0.3, 0.3, 7) * nonzero,
        alpha=parameters.alpha + [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6],
        corrections=frozenset({INERTIA_AT_ORIGIN})))  # and theta_2 = q_2
    expected = arm.mount @ transform(arm.parameters, 0, 7, q)
    np.testing.assert_allclose(arm.forward_kinematics(q), expected, **EXACT)


def test_jacobian_is_the_velocity_of_the_hand(arm, random_states):
    q, qd, _ = random_states(100)
    pose, slope = arm.forward_kinematics(q), rate(arm.forward_kinematics, q, qd)
    spin = slope[:, :3, :3] @ pose[:, :3, :3].swapaxes(-1, -2)  # skew(omega)
    expected = np.concatenate([slope[:, :3, 3], np.stack(
        [spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)], axis=-1)
    np.testing.assert_allclose((arm.jacobian(q) @ qd[..., None])[..., 0], expected, rtol=0.0,
                               atol=1e-9)


def test_pose_is_a_rigid_transform(arm, q):
    pose = arm.forward_kinematics(q)
    rotation = pose[:, :3, :3]
    np.testing.assert_allclose(rotation @ rotation.swapaxes(-1, -2),
                               np.broadcast_to(np.eye(3), rotation.shape), **EXACT)
    np.testing.assert_allclose(np.linalg.det(rotation), 1.0, **EXACT)
    np.testing.assert_array_equal(pose[:, 3], np.broadcast_to([0, 0, 0, 1], pose[:, 3].shape))

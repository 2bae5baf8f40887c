"""Pose and Jacobian of the hand against Pinocchio and eq. (2)."""

from dataclasses import replace

from baxter_dynamics_ros import BaxterArm, mount
from baxter_dynamics_ros.model.lagrange_euler import transform
from baxter_dynamics_ros.model.parameters import INERTIA_AT_ORIGIN, paper_parameters
import numpy as np
import pytest

EXACT = {'rtol': 0.0, 'atol': 1e-14}


@pytest.fixture
def q(random_states):
    return random_states(300)[0]


def test_pose_and_jacobian_against_pinocchio(arm, reference, q):
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


@pytest.mark.parametrize('side', ['right', 'left'])
def test_positive_directions(side):
    """As docs/model.md describes them, with all joints at zero."""
    jacobian = BaxterArm(mount=mount(side)).jacobian(np.zeros(7))
    forward, left, up = jacobian[:3]
    assert left[0] > 0.5 and abs(up[0]) < 1e-12
    assert all(up[joint] < -0.2 for joint in (1, 3, 5))
    outwards = BaxterArm(mount=mount(side)).forward_kinematics(np.zeros(7))[:3, 2]
    np.testing.assert_allclose(jacobian[3:, [2, 4, 6]].T, [outwards] * 3, atol=1e-12)

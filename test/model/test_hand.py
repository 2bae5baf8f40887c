"""The hand's fast kinematics against BaxterArm, against Pinocchio, and against its own motion."""

from dataclasses import replace

from baxter_dynamics_ros import BaxterArm, mount
from baxter_dynamics_ros.model.exceptions import ArgumentError
from baxter_dynamics_ros.model.hand import HandKinematics
from baxter_dynamics_ros.model.joints import SIDES
from baxter_dynamics_ros.model.parameters import INERTIA_AT_ORIGIN, paper_parameters
import numpy as np
import pytest

EXACT = {'rtol': 0.0, 'atol': 1e-14}
STEP = 3e-4  # of the fourth-order differences: truncation and rounding are both near 1e-11


@pytest.fixture
def q(random_states):
    return random_states(300)[0]


@pytest.fixture
def hand(arm):
    return HandKinematics(arm.parameters, arm.mount)


def each(function, q):
    """Return what a function of one state gives for each row of q."""
    return np.array([function(row) for row in q])


def rate(function, q, qd):
    """Return the derivative of a function of one state in the direction qd, for each row."""
    def at(t):
        return each(function, q + t * qd)
    return (8 * (at(STEP) - at(-STEP)) - (at(2 * STEP) - at(-2 * STEP))) / (12 * STEP)


def test_the_arm_has_the_same_pose(arm, hand, q):
    np.testing.assert_allclose(each(hand.pose, q), arm.forward_kinematics(q), **EXACT)


def test_the_arm_has_the_same_jacobian(arm, hand, q):
    np.testing.assert_allclose(each(hand.jacobian, q), arm.jacobian(q), **EXACT)


def test_pinocchio_has_the_same_pose(hand, reference, q):
    np.testing.assert_allclose(each(hand.pose, q), reference.forward_kinematics(q), **EXACT)


def test_pinocchio_has_the_same_jacobian(hand, reference, q):
    np.testing.assert_allclose(each(hand.jacobian, q), reference.jacobian(q), **EXACT)


@pytest.mark.parametrize('side', SIDES)
def test_on_either_mount(side, q):
    arm = BaxterArm(mount=mount(side))
    hand = HandKinematics(arm.parameters, arm.mount)
    np.testing.assert_allclose(each(hand.pose, q), arm.forward_kinematics(q), **EXACT)
    np.testing.assert_allclose(each(hand.jacobian, q), arm.jacobian(q), **EXACT)


def test_with_other_lengths_and_angles(q, rng):
    parameters = paper_parameters()
    elsewhere = np.array([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0])  # as the closed form asks
    arm = BaxterArm(mount=mount('left'), parameters=replace(
        parameters, a=rng.uniform(-0.3, 0.3, 7) * elsewhere,
        d=rng.uniform(-0.3, 0.3, 7) * elsewhere,
        alpha=parameters.alpha + [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6],
        corrections=frozenset({INERTIA_AT_ORIGIN})))  # and theta_2 = q_2
    hand = HandKinematics(arm.parameters, arm.mount)
    np.testing.assert_allclose(each(hand.pose, q), arm.forward_kinematics(q), **EXACT)
    np.testing.assert_allclose(each(hand.jacobian, q), arm.jacobian(q), **EXACT)


@pytest.mark.parametrize('name, i, change', [('alpha', 0, 0.1), ('a', 1, 0.1), ('d', 5, 0.1)])
def test_an_arm_built_otherwise_is_refused(name, i, change):
    parameters = paper_parameters()
    changed = getattr(parameters, name).copy()
    changed[i] += change
    with pytest.raises(ArgumentError, match='^parameters: expected Baxter'):
        HandKinematics(replace(parameters, **{name: changed}), np.eye(4))


def test_linear_rows_are_the_velocity_of_the_origin(hand, random_states):
    q, qd, _ = random_states(100)
    velocity = (each(hand.jacobian, q)[:, :3] @ qd[..., None])[..., 0]
    np.testing.assert_allclose(velocity, rate(hand.pose, q, qd)[:, :3, 3], rtol=0.0, atol=1e-9)


def test_angular_rows_are_the_angular_velocity(hand, random_states):
    q, qd, _ = random_states(100)
    rotation = each(hand.pose, q)[:, :3, :3]
    spin = rate(hand.pose, q, qd)[:, :3, :3] @ rotation.swapaxes(-1, -2)  # skew(omega)
    omega = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
    np.testing.assert_allclose((each(hand.jacobian, q)[:, 3:] @ qd[..., None])[..., 0], omega,
                               rtol=0.0, atol=1e-9)


def test_pose_is_a_rigid_transform(hand, q):
    pose = each(hand.pose, q)
    rotation = pose[:, :3, :3]
    np.testing.assert_allclose(rotation @ rotation.swapaxes(-1, -2),
                               np.broadcast_to(np.eye(3), rotation.shape), **EXACT)
    np.testing.assert_allclose(np.linalg.det(rotation), 1.0, **EXACT)
    np.testing.assert_array_equal(pose[:, 3], np.broadcast_to([0, 0, 0, 1], pose[:, 3].shape))


def test_a_state_is_only_read_and_results_are_new(hand, q):
    state = q[0].copy()
    state.flags.writeable = False
    for function, shape in ((hand.pose, (4, 4)), (hand.jacobian, (6, 7))):
        first, kept = function(state), function(state).copy()
        function(q[1])
        assert first.shape == shape
        np.testing.assert_array_equal(first, kept)
    np.testing.assert_array_equal(state, q[0])

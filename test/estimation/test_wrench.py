"""Wrench at the hand: the exerted wrench, or none near a singularity."""

from baxter_dynamics_ros import BaxterArm, mount
from baxter_dynamics_ros.estimation.external import hand_wrench, LEAST_SINGULAR_VALUE, LEVER
from baxter_dynamics_ros.model.joints import SIDES
from baxter_dynamics_ros.model.lagrange_euler import transform
from baxter_dynamics_ros.model.parameters import paper_parameters
import numpy as np
import pytest

SCALE = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])
NOISE = 0.1  # of each joint's external torque [N m]
ELBOW_OUT = np.array([0.3, -0.6, 0.4, 1.4, 0.5, 0.8, 0.2])  # far from any singularity [rad]


def _straight_elbow():
    """Return e1 [rad] at which shoulder, elbow and wrist are in line: a and d are offset there."""
    parameters = paper_parameters()
    a, d = parameters.a, parameters.d
    return np.arctan2(a[2], d[2]) - np.arctan2(a[4], d[4])


# Exactly singular: the axes of s0, e0, w0, w2 upright, without torque about a horizontal axis in
# the arm's plane; shoulder, elbow and wrist in line, without torque from a push along that line;
# the hand in line with the forearm and w0 a quarter turn, found by search.
SINGULAR = {
    'arm_upright': np.array([0.3, -np.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.2]),
    'elbow_straight': np.array([0.3, -0.4, 0.0, _straight_elbow(), 0.0, 0.9, -0.5]),
    'wrist_straight': np.array([0.3, -0.4, 0.3, 1.2, -1.5739013258058, 0.0267103681078, 0.5]),
}
singular = pytest.mark.parametrize('q', SINGULAR.values(), ids=SINGULAR.keys())


def mounted(side='right'):
    return BaxterArm(mount=mount(side))


def vector(wrench):
    return np.concatenate([wrench.force, wrench.torque])


def least_singular_value(jacobian):
    return np.linalg.svd(jacobian * SCALE[:, None], compute_uv=False)[..., -1]


def self_motion(jacobian):
    """Return the joint velocities (7,) of norm 1 that do not move the hand."""
    return np.linalg.svd(jacobian)[2][-1]


def test_exerted_wrench_is_returned(arm, random_states, rng):
    returned = 0
    for q in random_states(200)[0]:
        jacobian, exerted = arm.jacobian(q), rng.uniform(-30.0, 30.0, 6)
        wrench = hand_wrench(jacobian, jacobian.T @ exerted)
        if wrench is not None:
            np.testing.assert_allclose(vector(wrench), exerted, rtol=0.0, atol=1e-9)
            assert 0.0 <= wrench.unexplained < 1e-9
            returned += 1
    assert returned > 150


@pytest.mark.parametrize('axis', range(3))
@pytest.mark.parametrize('side', SIDES)
def test_a_push_along_an_axis_of_the_base_is_positive(side, axis):
    # Virtual work of 10 N, without a Jacobian.
    arm, step = BaxterArm(mount=mount(side)), 1e-6
    ahead, behind = (arm.forward_kinematics(ELBOW_OUT + sign * step * np.eye(7))[:, axis, 3]
                     for sign in (1.0, -1.0))
    torque = 10.0 * (ahead - behind) / (2 * step)
    wrench = hand_wrench(mounted(side).jacobian(ELBOW_OUT), torque)
    np.testing.assert_allclose(wrench.force, 10.0 * np.eye(3)[axis], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(wrench.torque, 0.0, rtol=0.0, atol=1e-6)


def test_wrench_is_the_least_squares_solution(arm, rng):
    jacobian, external = arm.jacobian(ELBOW_OUT), rng.uniform(-5.0, 5.0, 7)
    best, (square,), *_ = np.linalg.lstsq(jacobian.T, external, rcond=None)
    wrench = hand_wrench(jacobian, external)
    np.testing.assert_allclose(vector(wrench), best, rtol=1e-9, atol=1e-9)
    assert wrench.unexplained ** 2 == pytest.approx(square, abs=1e-9)


def test_unexplained_is_the_part_along_the_self_motion(arm, rng):
    jacobian, exerted = arm.jacobian(ELBOW_OUT), rng.uniform(-10.0, 10.0, 6)
    external = jacobian.T @ exerted - 2.5 * self_motion(jacobian)
    wrench = hand_wrench(jacobian, external)
    np.testing.assert_allclose(vector(wrench), exerted, rtol=0.0, atol=1e-12)
    assert wrench.unexplained == pytest.approx(2.5, abs=1e-12)


def test_a_push_on_the_elbow_differs_from_one_on_the_hand(arm):
    jacobian, step = arm.jacobian(ELBOW_OUT), 1e-6
    moved = (ELBOW_OUT + sign * step * np.eye(7) for sign in (1.0, -1.0))
    ahead, behind = ((arm.mount @ transform(arm.parameters, 0, 4, q))[:, :3, 3] for q in moved)
    elbow = (ahead - behind) / (2 * step)  # (7, 3), its Jacobian transposed [m]
    swing = self_motion(jacobian) @ elbow  # how the elbow can move while the hand rests [m]
    along = 10.0 * swing / np.linalg.norm(swing)  # [N]
    across = np.cross(along, [0.0, 0.0, 1.0])
    assert hand_wrench(jacobian, elbow @ along).unexplained > 1.0
    assert hand_wrench(jacobian, elbow @ across).unexplained < 1e-6
    assert hand_wrench(jacobian, jacobian[:3].T @ along).unexplained < 1e-12


@singular
@pytest.mark.parametrize('torque', [0.0, 1.0, 1e6])
def test_withheld_on_a_singularity(arm, q, torque):
    jacobian = arm.jacobian(q)
    assert least_singular_value(jacobian) < 1e-12
    assert hand_wrench(jacobian, np.full(7, torque)) is None


@singular
def test_withheld_around_a_singularity_and_continuous_beyond(arm, q, rng):
    external = rng.uniform(-1.0, 1.0, 7)
    way = ELBOW_OUT - q

    def at(s):
        return hand_wrench(arm.jacobian(q + s * way), external)

    assert all(at(s) is None for s in np.logspace(-16, -3, 60))
    near, far = 0.0, 1.0
    while far - near > 1e-12:  # where it is first returned
        middle = (near + far) / 2
        near, far = (middle, far) if at(middle) is None else (near, middle)
    assert least_singular_value(arm.jacobian(q + far * way)) == pytest.approx(
        LEAST_SINGULAR_VALUE, abs=1e-9)
    first, then = at(far), at(far + 1e-6)
    np.testing.assert_allclose(vector(first), vector(then), rtol=0.0, atol=1e-2)
    exerted = rng.uniform(-30.0, 30.0, 6)
    jacobian = arm.jacobian(q + far * way)
    np.testing.assert_allclose(vector(hand_wrench(jacobian, jacobian.T @ exerted)), exerted,
                               rtol=0.0, atol=1e-9)


def test_wrench_is_bounded_by_the_threshold(arm, random_states, rng):
    for q in random_states(500)[0]:
        jacobian, external = arm.jacobian(q), rng.normal(0.0, NOISE, 7)
        wrench = hand_wrench(jacobian, external)
        assert (wrench is None) == (least_singular_value(jacobian) < LEAST_SINGULAR_VALUE)
        if wrench is not None:
            limit = np.linalg.norm(external) / LEAST_SINGULAR_VALUE
            assert np.linalg.norm(vector(wrench) / SCALE) <= limit * (1 + 1e-9)


# The figures of the docstring.


def noise(jacobian):
    """Return the standard deviation of force [N] and torque [N m] in the worst direction."""
    wrenches = [hand_wrench(jacobian, x) for x in NOISE * np.eye(7)]
    if None in wrenches:
        return None
    parts = (np.array(part) for part in list(zip(*wrenches))[:2])
    return tuple(np.linalg.norm(part, 2) for part in parts)


def test_share_of_the_workspace_that_is_withheld(random_states):
    q, hand = random_states(3000)[0], mounted()
    withheld = np.array([hand_wrench(hand.jacobian(row), np.ones(7)) is None for row in q])
    assert withheld.mean() == pytest.approx(0.18, abs=0.015)
    straight = q[:, 3] < 0.3
    assert straight[withheld].mean() == pytest.approx(0.65, abs=0.05)
    assert withheld[straight].mean() > 0.85


def test_noise_is_below_5_newtons_wherever_a_wrench_is_returned(random_states):
    hand = mounted()
    errors = [noise(hand.jacobian(q)) for q in random_states(300)[0]]
    force, torque = np.array([error for error in errors if error is not None]).T
    assert 3.0 < force.max() <= 5.0
    assert 0.6 < torque.max() <= 1.25
    assert np.median(force) < 1.0

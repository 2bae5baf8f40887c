"""The trajectories: what moves and what stays, from rest, within the joints' limits."""

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.model.joints import POSITION_LOWER, POSITION_UPPER, VELOCITY_LIMIT
import numpy as np
import pytest

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

from baxter_dynamics_ros.simulation import trajectories  # noqa: E402, I100
from baxter_dynamics_ros.simulation.robot import FakeBaxter  # noqa: E402
from baxter_dynamics_ros.simulation.trajectories import (  # noqa: E402
    HandTrajectory, MIRROR, MOVE, PERIODS, POSTURES, RAMP, REST, TRAJECTORIES)
from tools.excitation_search import clearance  # noqa: E402

PERIOD = 0.01  # [s]
LAP = len(POSTURES) * (REST + MOVE)  # [s]
ORIGIN = np.zeros(3)


def follow(side, trajectory, seconds, period=PERIOD):
    """Return joint references q, qd (n, 7) every period [s], the first at the start."""
    reference = HandTrajectory(side, trajectory)
    rows = [(reference.q, reference.qd)]
    for _ in range(round(seconds / period)):
        reference.advance(period)
        rows.append((reference.q, reference.qd))
    return np.array(rows).transpose(1, 0, 2)


def hand(side, q):
    """Return the hand's poses (n, 4, 4) as the model sees them."""
    return BaxterArm(mount=mount(side)).forward_kinematics(q)


def mirrored(side):
    """Return the signs (3,) that mirror a position to the arm of a side."""
    return np.array([1.0, -1.0 if side == 'left' else 1.0, 1.0])


def test_switch_is_between_two_places_and_rests_in_each():
    y = np.array([TRAJECTORIES['switch'](t)[1] for t in np.arange(0.0, 40.0, 0.001)])
    assert (y.min(), y.max()) == pytest.approx((-0.3, -0.1))
    assert y[[0, 1300, 2000, 3300, 4000]] == pytest.approx([-0.1, -0.1, -0.3, -0.3, -0.1])
    assert np.mean(y > -0.1001) == pytest.approx(0.36, abs=0.02)
    assert np.mean(y < -0.2999) == pytest.approx(0.36, abs=0.02)
    acceleration = np.diff(y, 2) * 1e6
    assert np.abs(acceleration).max() == pytest.approx(3.2, abs=0.1)
    assert np.abs(np.diff(acceleration)).max() < 0.1  # no jump


@pytest.mark.parametrize('trajectory, axes', [
    ('circle', [0, 1, 2]), ('switch', [1]), ('lift', [2])])
def test_each_moves_along_its_axes_and_repeats_after_its_period(trajectory, axes):
    position, period = TRAJECTORIES[trajectory], PERIODS[trajectory]
    t = np.linspace(0.0, period, 50)
    moved, again = (np.array([position(x) for x in t + shift]) for shift in (0.0, 3 * period))
    assert np.flatnonzero(np.ptp(moved, axis=0)).tolist() == axes
    np.testing.assert_allclose(again, moved, atol=1e-9)
    shorter = [np.abs(position(1.8 + period / n) - position(1.8)).max() for n in (2, 3, 5)]
    assert min(shorter) > 1e-3


@pytest.mark.parametrize('trajectory', PERIODS)
def test_keeps_to_the_joint_limits_and_starts_at_rest_without_a_jump(trajectory):
    q, qd = follow('right', trajectory, 34.0, 0.04)
    assert min((q - POSITION_LOWER).min(), (POSITION_UPPER - q).min()) > 0.3
    assert (np.abs(qd) / VELOCITY_LIMIT).max() < 0.65
    q, qd = follow('right', trajectory, RAMP + 1.0)
    np.testing.assert_allclose(hand('right', q[0])[:3, 3], TRAJECTORIES[trajectory](0.0),
                               atol=1e-6)
    assert np.abs(qd[:2]).max() < 1e-3
    assert np.abs(np.diff(qd, axis=0)).max() / PERIOD < (8.0 if trajectory == 'switch' else 0.6)


def test_the_left_arm_mirrors_the_right():
    right, left = (follow(side, 'circle', 3.0)[0] for side in ('right', 'left'))
    np.testing.assert_allclose(left, MIRROR * right, atol=1e-6)
    np.testing.assert_allclose(hand('left', left)[:, :3, 3],
                               hand('right', right)[:, :3, 3] * mirrored('left'), atol=1e-6)


@pytest.mark.parametrize('side, trajectory, error', [
    ('left', 'circle', 0.012), ('right', 'switch', 0.07), ('right', 'lift', 0.007)])
def test_the_double_loop_brings_the_hand_along(side, trajectory, error):
    robot = FakeBaxter(side, trajectory, noise=False)
    rows = []
    for k in range(1, 601):
        robot.advance(k * PERIOD)
        rows.append((robot.plant.q, robot.plant.qd, robot.reference.q))
    q, qd, reference = np.array(rows).transpose(1, 0, 2)
    actual, position = hand(side, q), hand(side, reference)[:, :3, 3]
    wanted = [TRAJECTORIES[trajectory](k * PERIOD - RAMP / 2) for k in range(300, 601)]
    np.testing.assert_allclose(position[299:], wanted * mirrored(side), atol=1e-3)
    assert np.linalg.norm(actual[:, :3, 3] - position, axis=-1).max() < error
    assert actual[:, 2, 2].max() < -0.999  # hand down
    acceleration = np.abs(np.diff(qd[300:], axis=0)).max() / PERIOD
    if trajectory == 'switch':
        assert acceleration > 4.0
        assert np.abs(q[590] - reference[590]).max() < 5e-3  # 0.1 s before the next move
        assert np.abs(q[590] - q[580]).max() < 5e-3  # calm
    else:
        assert acceleration < 0.7  # friction that turns round, mostly


@pytest.fixture(scope='module')
def path():
    """Return the right arm's poses every 10 ms of three laps, (n, 7) [rad]."""
    return np.array([trajectories.poses(t) for t in np.arange(0.0, 3 * LAP, PERIOD)])


def test_poses_rest_in_each_posture_and_come_from_the_other_side_on_a_second_lap(path):
    assert len(POSTURES) == 3 and np.ptp(path[200:350], axis=0).min() > 0.1  # every joint moves
    for k, posture in enumerate(POSTURES):
        start = round(k * (REST + MOVE) / PERIOD)
        np.testing.assert_allclose(path[start:start + 200], np.tile(posture, (200, 1)), atol=1e-12)
        begin = start + round(LAP / PERIOD)
        way = np.sign(posture - POSTURES[k - 1])
        np.testing.assert_allclose(path[begin], posture + trajectories.OVERSHOOT * way, atol=1e-9)
        assert (way * (path[begin + 30] - posture) > 0.0).all()
        resting = path[begin + round(trajectories.RETURN_TIME / PERIOD):begin + 200]
        np.testing.assert_allclose(resting, np.tile(posture, (len(resting), 1)), atol=1e-9)
    n = round(LAP / PERIOD)
    np.testing.assert_allclose(path[2 * n + 1:], path[1:n], atol=1e-9)  # it repeats


def test_poses_keep_clear_of_the_robot_and_within_its_limits(path):
    assert clearance(path).min() > 0.05
    assert min((path - POSITION_LOWER).min(), (POSITION_UPPER - path).min()) > 0.3
    velocity = np.diff(path, axis=0) / PERIOD
    assert (np.abs(velocity) / VELOCITY_LIMIT).max() < 0.6
    acceleration = np.diff(velocity, axis=0) / PERIOD
    assert np.abs(acceleration).max() < 5.0
    assert np.abs(np.diff(acceleration, axis=0)).max() < 1.0  # no jump


def test_postures_tell_mass_and_centre_of_mass_of_a_payload_apart():
    columns = np.array([BaxterArm(payload=Payload(1.0, at)).gravity(POSTURES)
                        - BaxterArm().gravity(POSTURES) for at in np.vstack([ORIGIN, np.eye(3)])])
    columns[1:] -= columns[0]
    deviation = np.array([1.0, 2.0, 1.5, 1.1, 0.4, 0.6, 0.3])  # [N m], uncalibrated
    a = (columns / deviation).reshape(4, -1).T
    sd = np.sqrt(np.diag(np.linalg.inv(a.T @ a)))
    assert sd[0] < 0.15  # kg
    assert sd[1:].max() < 0.05  # kg m

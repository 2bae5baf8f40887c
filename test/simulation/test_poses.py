"""The trajectory poses: where it rests, what it keeps clear of, and from where it comes."""

from baxter_dynamics_ros import BaxterArm, Payload
from baxter_dynamics_ros.model.joints import POSITION_LOWER, POSITION_UPPER, VELOCITY_LIMIT
from baxter_dynamics_ros.simulation import trajectories
import numpy as np
import pytest
from tools.excitation_search import clearance

PERIOD = 0.01  # [s]
LAP = 3 * (trajectories.REST + trajectories.MOVE)  # [s]


@pytest.fixture(scope='module')
def path():
    """Return the right arm's positions every 10 ms of both laps and a bit, (n, 7) [rad]."""
    return np.array([trajectories.poses(t) for t in np.arange(0.0, 3 * LAP, PERIOD)])


def test_rests_for_two_seconds_in_each_of_three_postures_on_a_first_lap(path):
    for k, posture in enumerate(trajectories.POSTURES):
        start = round(k * (trajectories.REST + trajectories.MOVE) / PERIOD)
        np.testing.assert_allclose(path[start:start + 200], np.tile(posture, (200, 1)),
                                   atol=1e-12)
    assert len(trajectories.POSTURES) == 3
    assert np.ptp(path[200:350], axis=0).min() > 0.1  # every joint moves


def test_comes_from_the_other_side_on_a_second_lap(path):
    for k, posture in enumerate(trajectories.POSTURES):
        begin = round((LAP + k * (trajectories.REST + trajectories.MOVE)) / PERIOD)
        way = np.sign(posture - trajectories.POSTURES[k - 1])
        np.testing.assert_allclose(path[begin], posture + trajectories.OVERSHOOT * way, atol=1e-9)
        assert (way * (path[begin + 30] - posture) > 0.0).all()
        resting = path[begin + round(trajectories.RETURN_TIME / PERIOD):begin + 200]
        np.testing.assert_allclose(resting, np.tile(posture, (len(resting), 1)), atol=1e-9)


def test_repeats_after_its_period(path):
    n = round(LAP / PERIOD)
    np.testing.assert_allclose(path[2 * n + 1:], path[1:len(path) - 2 * n], atol=1e-9)


def test_keeps_clear_of_the_robot_and_within_its_limits(path):
    assert clearance(path).min() > 0.05
    assert min((path - POSITION_LOWER).min(), (POSITION_UPPER - path).min()) > 0.3
    velocity = np.diff(path, axis=0) / PERIOD
    assert (np.abs(velocity) / VELOCITY_LIMIT).max() < 0.6
    acceleration = np.diff(velocity, axis=0) / PERIOD
    assert np.abs(acceleration).max() < 5.0
    assert np.abs(np.diff(acceleration, axis=0)).max() < 1.0  # no jump


def test_postures_tell_mass_and_centre_of_mass_of_a_payload_apart():
    empty = BaxterArm()
    columns = [BaxterArm(payload=Payload(1.0, at)).gravity(trajectories.POSTURES)
               - empty.gravity(trajectories.POSTURES)
               for at in np.vstack([np.zeros(3), np.eye(3)])]
    columns = np.array([columns[0], *(each - columns[0] for each in columns[1:])])
    doubt = np.array([1.0, 2.0, 1.5, 1.1, 0.4, 0.6, 0.3])  # N m, where nothing is calibrated
    a = (columns / doubt).reshape(4, -1).T
    sd = np.sqrt(np.diag(np.linalg.inv(a.T @ a)))
    assert sd[0] < 0.15  # kg
    assert sd[1:].max() < 0.05  # kg m

"""The exciting trajectory: what it keeps to, and what it shows."""

import csv
import json

from baxter_dynamics_ros.calibration.live import progress
from baxter_dynamics_ros.model import EffortModel, joint_names, SIDES, VELOCITY_LIMIT
from baxter_dynamics_ros.model.joints import POSITION_LOWER, POSITION_UPPER
from baxter_dynamics_ros.simulation.exciting_trajectory import (
    DURATION, LimitedMotion, motion, series, write_plan, write_trajectory)
from baxter_dynamics_ros.simulation.trajectories import MIRROR
import numpy as np
import pytest
from tools import excitation_search

STEP = 0.01  # [s]
TIME = np.arange(0.0, DURATION + STEP / 2, STEP)


@pytest.fixture(scope='module')
def right():
    """Return q, qd, qdd (n, 7) of the right arm every 10 ms."""
    return motion(series('right'), TIME)


def judge(q, qd, qdd):
    """Return the condition number and the columns' own parts of a motion every 10 ms."""
    z = excitation_search.presliding(q)
    return excitation_search.judge(excitation_search.design(*(x[::10] for x in (q, qd, qdd, z))))


def test_keeps_to_the_joints_limits_and_sweeps_nearly_all_of_the_springs_range(right):
    q, qd, qdd = right
    lower, upper = EffortModel().spring_range
    assert lower < q[:, 1].min() and q[:, 1].max() < upper
    assert np.ptp(q[:, 1]) > 0.94 * (upper - lower)
    assert (q - POSITION_LOWER).min() > 0.1
    assert (POSITION_UPPER - q).min() > 0.1
    assert (np.abs(qd) / VELOCITY_LIMIT).max() < 0.6
    assert np.abs(qdd).max() < 6.0


def test_keeps_clear_of_the_robot_and_of_a_table_and_the_left_arm_mirrors_it(right):
    assert excitation_search.clearance(right[0]).min() > 0.0
    for ours, mirrored in zip(right, motion(series('left'), TIME)):
        np.testing.assert_allclose(mirrored, MIRROR * ours, atol=1e-12)


def test_clearance_is_negative_where_the_arm_is_not_clear():
    folded = np.array([[1.5, -0.5, 0.0, 2.4, 0.0, 1.5, 0.0],  # the hand before the chest
                       [0.0, 0.9, 0.0, 0.0, 0.0, 0.0, 0.0],  # below the table
                       [0.0, -2.0, 0.0, 0.3, 0.0, 0.0, 0.0]])  # back over the shoulder
    assert (excitation_search.clearance(folded) < 0.0).all()


def test_starts_and_ends_at_rest_and_is_twice_smooth(right):
    for x in right[1:]:
        assert np.abs(x[[0, -1]]).max() < 1e-12
    for x, slope in zip(right, right[1:]):  # derivatives as stated, so no jump below qdd's
        np.testing.assert_allclose(np.gradient(x, STEP, axis=0)[1:-1], slope[1:-1], atol=5e-3)
    assert np.abs(np.diff(right[2], axis=0)).max() < 0.2
    before, after = motion(series('right'), np.array([-1.0, DURATION + 1.0]))[0]
    np.testing.assert_array_equal(before, after)


@pytest.mark.parametrize('max_velocity, duration', [(np.inf, 60.0), (0.4, 205.1)])
def test_every_parameter_shows(max_velocity, duration):
    limited = LimitedMotion('right', max_velocity)
    assert limited.duration == pytest.approx(duration, abs=0.1)
    time = np.arange(0.0, limited.duration, STEP)
    q, qd, qdd = limited(time)
    assert np.abs(qd).max() <= max_velocity
    for x, slope in zip((q, qd), (qd, qdd)):
        np.testing.assert_allclose(np.gradient(x, STEP, axis=0)[1:-1], slope[1:-1], atol=5e-3)
    assert (progress(time, q)[0] == 1.0).all()
    condition, own = judge(q, qd, qdd)
    assert condition < 45.0
    assert min(own.values()) > 0.06
    assert min(value for name, value in own.items()
               if not name.startswith('spring') and name != 'bias_s1') > 0.25


def test_a_short_search_keeps_to_the_limits_of_the_joints_and_finds_better():
    first, better = (excitation_search.search(seed=2, evaluations=n) for n in (0, 20))
    assert excitation_search._cost(better) < excitation_search._cost(first)
    q, qd, qdd = motion(better, TIME)
    assert (q > POSITION_LOWER + 0.1).all() and (q < POSITION_UPPER - 0.1).all()
    assert (np.abs(qd) / VELOCITY_LIMIT).max() < 0.6


def test_plan_is_a_file_as_the_sdk_records_and_plays(tmp_path):
    path, side, other = tmp_path / 'plan.csv', 'left', 'right'
    write_plan(path, side, LimitedMotion(side, 1.0))
    with open(path) as file:
        header, *lines = csv.reader(file)
    names = {arm: [*joint_names(arm), f'{arm}_gripper'] for arm in SIDES}
    assert header == ['time', *names['left'], *names['right']]
    rows = np.array(lines, dtype=float)
    assert len(rows) == 1201 and (np.diff(rows[:, 0]) >= 0.0499).all()
    column = {name: rows[:, i] for i, name in enumerate(header)}
    q = np.array([column[name] for name in joint_names(side)]).T
    np.testing.assert_allclose(q, motion(series(side), np.arange(1201) / 20.0)[0], atol=1e-6)
    assert all(np.ptp(column[name]) == 0.0 for name in names[other])


def test_trajectory_is_a_joint_trajectory_that_follows_the_path(tmp_path):
    max_velocity = 0.4
    limited = LimitedMotion('left', max_velocity)
    write_trajectory(tmp_path / 'trajectory.json', 'left', limited)
    text = (tmp_path / 'trajectory.json').read_text()
    assert len(text) < 2 ** 17  # the longest argument of a command
    message = json.loads(text)
    assert tuple(message['joint_names']) == joint_names('left')
    stamps = [point['time_from_start'] for point in message['points']]
    time = np.array([stamp['sec'] + 1e-9 * stamp['nanosec'] for stamp in stamps])
    assert (np.diff(time) > 0.0).all() and time[-1] == pytest.approx(limited.duration, abs=1e-5)
    q, qd, qdd = (np.array([point[field] for point in message['points']])
                  for field in ('positions', 'velocities', 'accelerations'))
    assert np.abs(qd).max() <= max_velocity and not qd[[0, -1]].any()
    between = np.diff(time)[:, None]  # quintic interpolation in the middle of two points
    middle = ((q[1:] + q[:-1]) / 2 + 5 * between * (qd[:-1] - qd[1:]) / 32
              + between ** 2 * (qdd[:-1] + qdd[1:]) / 64)
    np.testing.assert_allclose(middle, limited((time[1:] + time[:-1]) / 2)[0], atol=2e-3)

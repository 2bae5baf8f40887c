"""The fake Baxter obeys torque commands and nothing else, and holds itself when they stop."""

from xml.etree import ElementTree

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.model import ArgumentError, joint_names
import numpy as np
import pytest

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

from baxter_dynamics_ros.model.effort import EffortModel  # noqa: E402, I100
from baxter_dynamics_ros.simulation.description import find_description  # noqa: E402
from baxter_dynamics_ros.simulation.plant import default_truth, TORQUE_LIMIT  # noqa: E402
from baxter_dynamics_ros.simulation.robot import (  # noqa: E402
    COMMAND_TIMEOUT, FakeBaxter, JOINT_STATE_NAMES)

STEP = 0.001  # [s], of the robot's time
ORDER = [JOINT_STATE_NAMES.index(name) for name in joint_names('right')]


@pytest.fixture
def robot():
    """Return a fake Baxter at rest, with springs and without friction or noise."""
    return FakeBaxter(trajectory='hold', noise=False, truth=default_truth(friction=False))


def live(robot, seconds, command=None):
    """Return q, qd and published effort, each (n, 7), of every time step of the next seconds."""
    rows = []
    for _ in range(round(seconds / STEP)):
        if command is not None:
            robot.command(command)
        robot.advance(robot.time + STEP)
        rows.append((robot.plant.q, robot.plant.qd, robot.joint_state()[2][ORDER]))
    return np.array(rows).transpose(1, 0, 2)


def test_published_effort_is_the_commanded_torque_and_the_sensors_bias():
    bias = np.array([0.5, -0.4, 0.3, -0.2, 0.1, 0.05, -0.02])
    robot = FakeBaxter(noise=False, truth=EffortModel(bias=bias))
    command = np.array([1.0, -20.0, 0.5, -9.0, 0.3, -0.2, 0.01])
    _, _, effort = live(robot, 0.1, command)
    expected = np.tile(EffortModel().coupled(command + bias), (100, 1))
    np.testing.assert_allclose(effort, expected, atol=1e-12)


@pytest.mark.parametrize('off, falls', [(0.0, False), (0.3, True)])
def test_rests_under_gravity_and_spring_torque_alone(robot, off, falls):
    push = off * np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0])  # w2 alone would run away
    q, qd, _ = live(robot, 0.7, robot.plant.static_torque() + push)
    assert (np.abs(q - q[0]).max() > 0.05) == falls
    if not falls:
        assert np.abs(q - q[0]).max() < 1e-6
        assert np.abs(qd).max() < 1e-6


def test_moves_as_the_torque_accelerates_it(robot):
    push = np.array([2.0, -1.0, 0.5, 1.0, 0.1, -0.1, 0.003])
    robot.command(robot.plant.static_torque() + push)
    arm, before = BaxterArm(), robot.plant.q
    robot.advance(STEP)
    needed = arm.mass_matrix(before) @ robot.plant.qd / STEP
    np.testing.assert_allclose(needed, push, atol=0.02)
    np.testing.assert_allclose(robot.plant.q - before, robot.plant.qd * STEP, atol=1e-12)


def test_obeys_for_the_timeout_and_then_holds_the_place_without_a_jump(robot):
    command = robot.plant.static_torque() + np.array([0.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    robot.command(command)
    assert robot.is_commanded
    _, _, obeyed = live(robot, COMMAND_TIMEOUT)
    expected = robot.plant.truth.coupled(command)
    np.testing.assert_allclose(obeyed, np.tile(expected, (200, 1)), atol=1e-12)
    left_at = robot.plant.q
    q, qd, effort = live(robot, 1.0)
    assert not robot.is_commanded
    np.testing.assert_allclose(effort[0], expected, atol=1e-9)
    assert np.abs(np.diff(effort, axis=0)).max() < 1.0  # N m in 1 ms
    np.testing.assert_allclose(q[-1], left_at, atol=2e-3)
    assert np.abs(qd[-1]).max() < 2e-3


def test_does_not_take_the_trajectory_up_again():
    robot = FakeBaxter(trajectory='switch', noise=False)
    robot.advance(2.4)  # under way
    robot.command(robot.plant.static_torque())
    q, _, _ = live(robot, 1.2)
    assert np.ptp(q[-600:], axis=0).max() < 0.02
    np.testing.assert_allclose(q[-1], q[200], atol=0.05)


@pytest.mark.parametrize('torque, problem', [
    (np.zeros(6), r'torque: expected shape \(7,\)'),
    ([0.0, 0.0, np.nan, 0.0, 0.0, 0.0, 0.0], 'torque: expected finite values, got nan'),
    ([0.0, -50.1, 0.0, 0.0, 0.0, 0.0, 0.0], 'torque: expected at most 50 N m at s1, got -50.1'),
    ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 16.0], 'torque: expected at most 15 N m at w2, got 16'),
])
def test_what_no_motor_can_do_is_refused_and_changes_nothing(robot, torque, problem):
    with pytest.raises(ArgumentError, match=problem):
        robot.command(torque)
    assert not robot.is_commanded
    good = robot.plant.static_torque()
    robot.command(good)
    with pytest.raises(ArgumentError):
        robot.command(torque)
    _, _, effort = live(robot, 0.01)
    np.testing.assert_allclose(effort[-1], robot.plant.truth.coupled(good), atol=1e-12)


def test_a_joint_that_runs_away_is_braked_and_no_command_is_obeyed_meanwhile(robot):
    push = robot.plant.static_torque()
    push[6] = TORQUE_LIMIT[6]
    fastest = 0.0
    for k in range(300):  # [ms], as long as a controller of the wrong sign commands it
        try:
            robot.command(push)
        except ArgumentError as error:
            assert 'w2 is too fast' in str(error)
        robot.advance(robot.time + STEP)
        fastest = max(fastest, np.abs(robot.plant.qd).max())
    assert 40.0 < fastest < 100.0  # rad/s; MuJoCo gives up after 187 ms otherwise
    live(robot, 1.5)
    assert np.abs(robot.plant.qd).max() < 0.01
    robot.command(robot.plant.static_torque())


def test_limits_are_those_of_the_description():
    joints = {joint.get('name'): joint for joint in
              ElementTree.parse(find_description()).getroot().findall('joint')}
    efforts = [float(joints[name].find('limit').get('effort')) for name in joint_names('right')]
    np.testing.assert_array_equal(TORQUE_LIMIT, efforts)

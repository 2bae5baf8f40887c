"""Torque commands to the fake Baxter: matched by name, refused where not wholly good, logged."""

from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest
from sensor_msgs.msg import JointState

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

NAMES = joint_names('left')


@pytest.fixture
def baxter(robot, start):
    """Start a fake Baxter that holds its left arm, and what commands it; return its process."""
    process = start('fake_baxter', '-p', 'trajectory:=hold', '-p', 'arm:=left', '-p',
                    'noise:=false', '-p', 'spring:=false')
    robot.commander = robot.create_publisher(JointState, '/fake_baxter/joint_torque_command', 10)
    robot.states = robot.listen(JointState, '/robot/joint_states')
    robot.until(lambda: robot.commander.get_subscription_count() and robot.states)
    return process


def effort(robot):
    """Return the newest measured effort of the arm, (7,) [N m], in joint order."""
    newest = [m for m in robot.states if NAMES[0] in m.name][-1]
    return np.array([newest.effort[newest.name.index(name)] for name in NAMES])


def test_commands_are_matched_by_name_and_bad_ones_refused(robot, baxter):
    robot.until(lambda: any(NAMES[0] in m.name for m in robot.states))
    holding = effort(robot)
    command = holding + [0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07]
    names = ['head_pan', *NAMES[::-1]]
    good = JointState(name=names, effort=[99.0, *command[::-1].tolist()])

    robot.commander.publish(good)
    robot.until(lambda: np.allclose(effort(robot), command, atol=1e-9))

    bad = [JointState(name=names[:-1], effort=good.effort[:-1]),  # no s0
           JointState(name=['left_s0', *names[1:]], effort=good.effort),  # twice
           JointState(name=[name.replace('left', 'right') for name in names], effort=good.effort),
           JointState(name=names, position=good.effort),  # no effort
           JointState(name=names, effort=[*good.effort[:-1], float('nan')]),
           JointState(name=names, effort=[*good.effort[:-1], 51.0])]
    for each in bad:
        each.effort = [2.0 * x for x in each.effort]  # it would show
        robot.commander.publish(good)
        robot.commander.publish(each)
        robot.spin(0.07)
        np.testing.assert_allclose(effort(robot), command, atol=1e-9)
    assert 'expected each of left_s0 left_s1' in baxter.output
    assert baxter.output.count('motors supply them and nothing else') == 1

    robot.until(lambda: 'no torque command is obeyed now: the arm is held' in baxter.output)
    robot.spin(0.8)
    assert np.abs(effort(robot) - holding).max() < 1.0  # N m
    robot.commander.publish(bad[0])
    robot.until(lambda: '7 torque commands refused so far' in baxter.output)  # once a second

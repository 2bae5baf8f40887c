"""Torque commands to the fake Baxter: matched by name, refused as a whole, logged."""

import re

from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest
from sensor_msgs.msg import JointState

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

NAMES = joint_names('left')


@pytest.fixture
def baxter(robot, start):
    """Start a fake Baxter that holds its left arm, and a commander; return the process."""
    process = start('fake_baxter', '-p', 'trajectory:=hold', '-p', 'arm:=left', '-p',
                    'noise:=false', '-p', 'spring:=false')
    robot.commander = robot.create_publisher(JointState, '/fake_baxter/joint_torque_command', 10)
    robot.states = robot.listen(JointState, '/robot/joint_states')
    robot.until(lambda: robot.commander.get_subscription_count() and robot.states)
    return process


def efforts(robot):
    """Return the measured efforts of the arm so far, (n, 7) [N m], in joint order."""
    return np.array([[m.effort[m.name.index(name)] for name in NAMES]
                     for m in robot.states if NAMES[0] in m.name])


def refused(process):
    """Return how many commands the log says were refused."""
    return max(map(int, re.findall(r'(\d+) torque commands rejected', process.output)), default=0)


def test_commands_are_matched_by_name_and_bad_ones_refused(robot, baxter):
    robot.until(lambda: any(NAMES[0] in m.name for m in robot.states))
    holding = efforts(robot)[-1]
    command = holding + [0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07]
    names = ['head_pan', *NAMES[::-1]]
    good = JointState(name=names, effort=[99.0, *command[::-1].tolist()])

    def obeyed():
        """Command, for a command holds for 0.2 s only, and tell whether it is obeyed."""
        robot.commander.publish(good)
        return np.allclose(efforts(robot)[-1], command, atol=1e-9)

    robot.until(obeyed)
    bad = [JointState(name=names[:-1], effort=good.effort[:-1]),  # no s0
           JointState(name=['left_s0', *names[1:]], effort=good.effort),  # twice
           JointState(name=[name.replace('left', 'right') for name in names], effort=good.effort),
           JointState(name=names, position=good.effort),  # no effort
           JointState(name=names, effort=[*good.effort[:-1], float('nan')]),
           JointState(name=names, effort=[*good.effort[:-1], 51.0])]
    for each in bad:
        each.effort = [2.0 * x for x in each.effort]  # it would show
        robot.states.clear()
        robot.commander.publish(each)
        robot.until(lambda: len(efforts(robot)) > 5 and obeyed())
        assert np.abs(efforts(robot) - command).max() < np.abs(command).max() / 2
    assert 'expected left_s0 left_s1' in baxter.output
    assert 'applying them without gravity compensation' in baxter.output

    robot.until(lambda: 'torque commands ended: holding the present position' in baxter.output)
    robot.until(lambda: np.abs(efforts(robot)[-1] - holding).max() < 1.0)  # N m
    robot.until(lambda: robot.commander.publish(bad[0]) or refused(baxter) > len(bad))

"""The fake Baxter as a process: rates, names, stamps, payload, torque commands, refusals."""

import re

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.model import EffortModel, joint_names
import numpy as np
import pytest
from sensor_msgs.msg import JointState

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

NAMES = joint_names('left')
HOLD_LEFT = ('-p', 'trajectory:=hold', '-p', 'arm:=left', '-p', 'noise:=false')


def efforts(robot):
    """Return the measured efforts of the left arm so far, (n, 7) [N m], in joint order."""
    return np.array([[m.effort[m.name.index(name)] for name in NAMES]
                     for m in robot.states if NAMES[0] in m.name])


def test_publishes_as_the_robot_does_and_effort_with_payload_and_tilt(robot, start, stamps):
    robot.states = robot.listen(JointState, '/robot/joint_states')
    load, gravity = Payload(0.8, (0.0, 0.05, 0.1)), (0.3, 0.2, -9.8)
    start('fake_baxter', *HOLD_LEFT, '-p', 'friction:=false', '-p', 'payload.mass:=0.8', '-p',
          'payload.center_of_mass:=[0.0, 0.05, 0.1]', '-p', 'gravity:=[0.3, 0.2, -9.8]')
    robot.until(lambda: len(robot.states) > 200, 40.0)
    arms = [m for m in robot.states if NAMES[0] in m.name]
    grippers = [m for m in robot.states if NAMES[0] not in m.name]
    assert {len(m.name) for m in arms} == {17}
    assert all('gripper' in name for m in grippers for name in m.name)
    assert max(stamps(arms)) <= robot.get_clock().now().nanoseconds
    for kind, rate in ((arms, 100.0), (grippers, 38.0)):
        periods = np.diff(stamps(kind)) * 1e-9
        assert (periods > 0.0).all()
        # The robot's own stamps, not times of arrival; a slow machine may skip time.
        assert np.median(periods) == pytest.approx(1.0 / rate, rel=0.02)
        assert np.mean(np.abs(periods - 1.0 / rate) < 2e-3) > 0.9
    q = np.array([arms[0].position[arms[0].name.index(name)] for name in NAMES])
    arm, model = BaxterArm(payload=load, gravity=gravity, mount=mount('left')), EffortModel()
    np.testing.assert_allclose(efforts(robot)[0], model.coupled(arm.gravity(q) + model.spring(q)),
                               atol=0.02)


def test_a_low_rate_is_not_taken_for_a_slow_machine(robot, start):
    messages = robot.listen(JointState, '/robot/joint_states')
    process = start('fake_baxter', '-p', 'rate:=1.0')
    robot.until(lambda: sum('right_s0' in m.name for m in messages) >= 3, 30.0)
    assert process.output.count('behind') < 3  # a stalled machine is behind once in a while


def test_bad_values_are_refused(refusals):
    cases = {
        'arm:=both': 'arm: expected one of right, left',
        'trajectory:=spiral': 'trajectory: expected one of circle, switch, lift, exciting, hold',
        'payload.mass:=-1.0': 'payload.mass: expected a value in [0, 10] kg, got -1',
        'payload.center_of_mass:=[1.0]': 'payload.center_of_mass: expected shape (3,)',
        'gravity:=[0.0, 0.0, -98.1]': 'gravity[2]: expected a value in [-30, 30] m/s^2, got -98.1',
        'description:=/nowhere.urdf': '/nowhere.urdf: cannot be read',
        'rate:=0.0': 'rate: expected a value in [1, 1000] Hz, got 0',
        'forse:=[1.0, 0.0, 0.0]': 'did you mean force?'}
    lines = refusals('fake_baxter', [[argument] for argument in cases])
    for problem, line in zip(cases.values(), lines):
        assert problem in line


def test_commands_are_matched_by_name_and_bad_ones_refused(robot, start):
    process = start('fake_baxter', *HOLD_LEFT, '-p', 'spring:=false')
    commander = robot.create_publisher(JointState, '/fake_baxter/joint_torque_command', 10)
    robot.states = robot.listen(JointState, '/robot/joint_states')
    robot.until(lambda: commander.get_subscription_count() and len(efforts(robot)))
    holding = efforts(robot)[-1]
    command = holding + [0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07]
    names = ['head_pan', *NAMES[::-1]]
    good = JointState(name=names, effort=[99.0, *command[::-1].tolist()])

    def is_applied():
        """Command, for a command holds for 0.2 s only, and return whether it is applied."""
        commander.publish(good)
        return len(efforts(robot)) and np.allclose(efforts(robot)[-1], command, atol=1e-9)

    robot.until(is_applied)
    bad = [JointState(name=names[:-1], effort=good.effort[:-1]),  # no s0
           JointState(name=['left_s0', *names[1:]], effort=good.effort),  # twice
           JointState(name=[name.replace('left', 'right') for name in names], effort=good.effort),
           JointState(name=names, position=good.effort),  # no effort
           JointState(name=names, effort=[*good.effort[:-1], float('nan')]),
           JointState(name=names, effort=[*good.effort[:-1], 51.0])]
    for each in bad:
        each.effort = [2.0 * x for x in each.effort]  # it would show
        robot.states.clear()
        commander.publish(each)
        robot.until(lambda: len(efforts(robot)) > 5 and is_applied())
        assert np.abs(efforts(robot) - command).max() < np.abs(command).max() / 2
    assert 'expected left_s0 left_s1' in process.output
    assert 'applying them without gravity compensation' in process.output

    robot.until(lambda: 'torque commands ended: holding the present position' in process.output)
    robot.until(lambda: np.abs(efforts(robot)[-1] - holding).max() < 1.0)  # N m
    robot.until(lambda: commander.publish(bad[0]) or max(map(int, re.findall(
        r'(\d+) torque commands rejected', process.output)), default=0) > len(bad))

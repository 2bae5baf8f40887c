"""The fake Baxter as a process: rates, names, stamps, payload."""

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest
from sensor_msgs.msg import JointState

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')


def test_publishes_as_the_robot_does(robot, start, stamps):
    messages = []
    robot.create_subscription(JointState, '/robot/joint_states', messages.append, 1000)
    start('fake_baxter')
    robot.until(lambda: len(messages) > 200, 40.0)
    arms = [m for m in messages if 'right_s0' in m.name]
    grippers = [m for m in messages if 'right_s0' not in m.name]
    assert {len(m.name) for m in arms} == {17}
    assert all('gripper' in name for m in grippers for name in m.name)
    assert max(stamps(arms)) <= robot.get_clock().now().nanoseconds
    for kind, rate in ((arms, 100.0), (grippers, 38.0)):
        periods = np.diff(stamps(kind)) * 1e-9
        assert (periods > 0.0).all()
        # The robot's own stamps, not times of arrival; a slow machine may skip time.
        assert np.median(periods) == pytest.approx(1.0 / rate, rel=0.02)
        assert np.mean(np.abs(periods - 1.0 / rate) < 2e-3) > 0.9


def test_a_low_rate_is_not_taken_for_a_slow_machine(robot, start):
    messages = []
    robot.create_subscription(JointState, '/robot/joint_states', messages.append, 1000)
    process = start('fake_baxter', '-p', 'rate:=1.0')
    robot.until(lambda: sum('right_s0' in m.name for m in messages) >= 3, 30.0)
    assert process.output.count('behind') < 3  # a stalled machine is behind once in a while


def test_payload_and_tilt_are_in_the_effort(robot, start):
    messages = []
    robot.create_subscription(JointState, '/robot/joint_states', messages.append, 1000)
    load, gravity = Payload(0.8, (0.0, 0.05, 0.1)), (0.3, 0.2, -9.8)
    start('fake_baxter', '-p', 'trajectory:=hold', '-p', 'arm:=left', '-p',
          'friction:=false', '-p', 'noise:=false', '-p', 'payload.mass:=0.8', '-p',
          'payload.center_of_mass:=[0.0, 0.05, 0.1]', '-p', 'gravity:=[0.3, 0.2, -9.8]')
    robot.until(lambda: any('right_s0' in m.name for m in messages))
    message = next(m for m in messages if 'right_s0' in m.name)
    order = [list(message.name).index(name) for name in joint_names('left')]
    q, effort = (np.array(field)[order] for field in (message.position, message.effort))
    arm = BaxterArm(payload=load, gravity=gravity, mount=mount('left'))
    model = EffortModel()
    np.testing.assert_allclose(effort, model.coupled(arm.gravity(q) + model.spring(q)), atol=0.02)


def test_bad_values_are_refused(refusals):
    cases = {
        'arm:=both': 'arm: expected one of right, left',
        'trajectory:=spiral': 'trajectory: expected one of circle, switch, lift, exciting, hold',
        'payload.mass:=-1.0': 'payload.mass: expected a value in [0, 10] kg, got -1',
        'payload.center_of_mass:=[1.0]': 'payload.center_of_mass: expected shape (3,)',
        'gravity:=[0.0, 0.0, -98.1]': 'gravity[2]: expected a value in [-30, 30] m/s^2, got -98.1',
        'force:=[1.0]': 'force: expected shape (3,)',
        'description:=/nowhere.urdf': '/nowhere.urdf: cannot be read',
        'rate:=0.0': 'rate: expected a value in [1, 1000] Hz, got 0',
        'seed:=-1': 'seed: expected a value in [0, 2.14748e+09], got -1',
        'spring:=1.0': 'spring: expected true or false, got 1.0',
        'forse:=[1.0, 0.0, 0.0]': 'did you mean force?'}
    lines = refusals('fake_baxter', [[argument] for argument in cases])
    for problem, line in zip(cases.values(), lines):
        assert problem in line

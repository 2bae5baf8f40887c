"""The fake Baxter as a process: rates, names, stamps, and a force from outside."""

from baxter_dynamics_ros import BaxterArm, mount, Payload
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.joints import joint_names
from baxter_dynamics_ros.nodes.fake_baxter import main
import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')


def test_publishes_as_the_robot_does(robot, start, stamps):
    messages = []
    robot.create_subscription(JointState, '/robot/joint_states', messages.append, 1000)
    start('fake_baxter')
    robot.until(lambda: len(messages) > 300, 40.0)
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
    robot.until(lambda: sum('right_s0' in m.name for m in messages) >= 4, 30.0)
    assert process.output.count('behind') < 3  # a stalled machine is behind once in a while


def test_force_is_a_parameter_and_is_seen_by_the_predictor(robot, start):
    start('fake_baxter', '-p', 'trajectory:=hold')
    start('torque_predictor')
    robot.until(lambda: len(robot.residual) > 100, 30.0)
    before = np.mean([m.effort for m in robot.residual[-50:]], axis=0)

    client = robot.create_client(SetParameters, '/fake_baxter/set_parameters')
    assert client.wait_for_service(timeout_sec=10.0)

    def push(force):
        future = client.call_async(SetParameters.Request(parameters=[
            Parameter('force', value=force).to_parameter_msg()]))
        rclpy.spin_until_future_complete(robot, future, timeout_sec=10.0)
        return future.result().results[0]
    assert push([0.0, 0.0, -20.0]).successful
    # Pushed down, the shoulder must lift more: s1 turns the arm down when positive.
    robot.until(lambda: np.mean([m.effort[1] for m in robot.residual[-50:]]) < before[1] - 5.0)

    refused = push([0.0, 0.0, 1e6])
    assert not refused.successful
    assert 'force' in refused.reason


def test_payload_and_tilt_are_in_the_effort(robot, start):
    messages = []
    robot.create_subscription(JointState, '/robot/joint_states', messages.append, 1000)
    load, gravity = Payload(0.8, (0.0, 0.05, 0.1)), (0.3, 0.2, -9.8)
    start('fake_baxter', '-p', 'trajectory:=hold', '-p', 'friction:=false', '-p',
          'noise:=false', '-p', 'payload.mass:=0.8', '-p',
          'payload.center_of_mass:=[0.0, 0.05, 0.1]', '-p', 'gravity:=[0.3, 0.2, -9.8]')
    robot.until(lambda: any('right_s0' in m.name for m in messages))
    message = next(m for m in messages if 'right_s0' in m.name)
    order = [list(message.name).index(name) for name in joint_names('right')]
    q, effort = (np.array(field)[order] for field in (message.position, message.effort))
    arm = BaxterArm(payload=load, gravity=gravity, mount=mount('right'))
    np.testing.assert_allclose(effort, arm.gravity(q) + EffortModel().spring(q), atol=0.02)


def test_exciting_trajectory_moves_all_joints_of_the_arm(robot, start):
    messages = []
    robot.create_subscription(JointState, '/robot/joint_states', messages.append, 1000)
    start('fake_baxter', '-p', 'trajectory:=exciting', '-p', 'arm:=left', '-p', 'noise:=false')
    robot.until(lambda: sum('right_s0' in m.name for m in messages) > 250)
    names = max((m.name for m in messages), key=len)
    q = np.array([m.position for m in messages if 'right_s0' in m.name])
    moved = {name for name, by in zip(names, np.ptp(q, axis=0)) if by > 0.01}
    assert moved == set(joint_names('left'))


@pytest.fixture
def refused(domain, capfd):
    """Return a function that asserts the same as ``refuses``, in this process."""
    def refused_(argument: str, problem: str):
        try:
            assert main(['fake_baxter', '--ros-args', '-p', argument]) == 1
        finally:
            rclpy.try_shutdown()
        (line,) = capfd.readouterr().err.splitlines()
        assert line.startswith('fake_baxter: ')
        assert problem in line
    return refused_


def test_a_process_ends_with_one_clear_line_and_exit_code_1(refuses):
    refuses('fake_baxter', 'arm:=middle', 'arm: expected one of right, left')


@pytest.mark.parametrize('argument, problem', [
    ('arm:=both', 'arm: expected one of right, left'),
    ('trajectory:=spiral', 'trajectory: expected one of circle, switch, lift, exciting, hold'),
    ('payload.mass:=-1.0', 'payload.mass: expected a value in [0, 10] kg, got -1'),
    ('payload.center_of_mass:=[1.0]', 'payload.center_of_mass: expected shape (3,)'),
    ('gravity:=[0.0, 0.0, -98.1]', 'gravity[2]: expected a value in [-30, 30] m/s^2, got -98.1'),
    ('force:=[1.0]', 'force: expected shape (3,)'),
    ('description:=/nowhere.urdf', '/nowhere.urdf: cannot be read'),
    ('rate:=0.0', 'rate: expected a value in [1, 1000] Hz, got 0'),
    ('seed:=-1', 'seed: expected a value in [0, 2.14748e+09], got -1'),
    ('spring:=1.0', 'spring: expected true or false, got 1.0'),
    ('forse:=[1.0, 0.0, 0.0]', 'did you mean force?'),
])
def test_a_bad_value_is_one_clear_line_and_exit_code_1(refused, argument, problem):
    refused(argument, problem)

"""The node on input of simulators and other robots: NaN, prefixes, useless stamps, overload."""

import time

from baxter_dynamics_ros.model.joints import joint_names
from baxter_dynamics_ros.nodes.message_loss import MessageLoss
import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_msgs.msg import Bool, String

PERIOD = 0.01  # [s]
START = 10 ** 18  # [ns]
WARN, STALE = b'\x01', b'\x03'


def states(sine, seconds):
    """Return position and velocity (n, 7) of the arm."""
    q, qd, _ = sine(np.arange(0.0, seconds, PERIOD))
    return q, qd


def test_gazebo_publishes_nan_effort(robot, predictor, sine):
    """gz_ros2_control's message of Baxter: 17 joints in its own order, effort not available."""
    arm = joint_names('right')
    names = ['head_pan', *joint_names('left'), 'torso_t0', *arm[::-1], 'head_nod']
    contact = []
    robot.create_subscription(Bool, '/torque_predictor/contact', contact.append, 10)
    q, qd = states(sine, 2.0)
    for k in range(len(q)):
        fields = [[row[k][arm.index(name)] if name in arm else other for name in names]
                  for row, other in ((q, np.nan), (qd, np.nan))]
        robot.send(START + k * 10_000_000, names, *fields, [np.nan] * 17)
        robot.spin(PERIOD)
    robot.until(lambda: len(robot.predicted) == len(q) - 21)
    assert not robot.residual and not contact
    report = robot.report()
    assert report['effort'][2]['effort_missing'] == str(len(q))
    assert report['input'][2]['non_finite'] == '0'
    assert predictor.output.count('no measured effort (empty or NaN)') == 1


def test_prefix_and_frame(robot, start_predictor, sine):
    start_predictor('-p', 'joint_prefix:=robot_1/', '-p', 'frame_id:=robot_1/base')
    names = ['robot_1/' + name for name in joint_names('right')]
    q, qd = states(sine, 1.0)
    for k in range(len(q)):
        robot.send(START + k * 10_000_000, names, q[k], qd[k])
        robot.spin(PERIOD)
    robot.until(lambda: len(robot.predicted) == len(q) - 21)
    assert list(robot.predicted[0].name) == names
    assert robot.predicted[0].header.frame_id == 'robot_1/base'


@pytest.mark.parametrize('names, words', [
    (['base/right_s0', 'gripper\x1b[31m'], ['base/right_s0', 'gripper\\x1b[31m', 'joint_prefix']),
    ([], ['have no joint names'])], ids=['other names', 'nameless'])
def test_other_names_are_reported(robot, predictor, names, words):
    robot.until(lambda: robot.send(START, names, np.zeros(len(names))) or any(
        status.level == STALE and all(word in status.message for word in words)
        and 'right_s0 ... right_w2' in status.message
        for message in robot.diagnostics for status in message.status
        if status.name == 'torque_predictor: input'))
    assert '\x1b' not in predictor.output


def test_another_type_is_reported(robot, start):
    robot.create_publisher(String, '/text', 1)
    start('torque_predictor', '-r', '/robot/joint_states:=/text')
    robot.until(lambda: any(
        'published as std_msgs/msg/String' in status.message
        for message in robot.diagnostics for status in message.status))


@pytest.mark.parametrize('stamp', [0, START], ids=['zero', 'still'])
def test_useless_stamps(robot, predictor, sine, stamps, stamp):
    begin = time.time_ns()
    q, qd = states(sine, 4.5)
    for k in range(len(q)):
        robot.send_arm(stamp, q[k], qd[k], np.ones(7) + 0.004 * (k % 7))
        robot.spin(PERIOD)
    robot.until(lambda: robot.predicted and stamps(robot.predicted)[-1] > begin + 2 * 10 ** 9)
    assert stamps(robot.predicted)[-1] < time.time_ns()
    robot.until(lambda: any(
        status.message == 'using re-timed times of receipt'
        for message in robot.diagnostics for status in message.status))


def test_messages_lost_by_the_middleware_are_counted(robot, start_predictor, sine):
    start_predictor('-p', 'qos_overrides./robot/joint_states.subscription.depth:=5')
    q, qd = states(sine, 10.0)
    for k in range(len(q)):  # faster than any node takes them
        robot.send_arm(START + k * 10_000_000, q[k], qd[k], np.ones(7))
    robot.spin(0.5)
    robot.send_arm(START + len(q) * 10_000_000, q[0], qd[0], np.ones(7))
    values = robot.report()['input'][2]
    assert int(values['received']) + int(values['lost']) == len(q) + 1


@pytest.mark.parametrize('publishers, numbers, lost', [
    (1, [1, 2, 3, 4], 0), (1, [7, 8, 10, 11], 1), (1, [1, 2, 1, 2, 4], 1), (1, [None, None], 0),
    (2, [1, 1000, 2, 1001, 3, 1003, 4], 1), (2, [5, 900, 901, 6, 7, 902, 9], 1)])
def test_gaps_in_sequence_numbers(publishers, numbers, lost):
    loss = MessageLoss()
    loss.matched(publishers)
    for number in numbers:
        loss.received(number)
    assert loss.lost == lost


def test_a_large_parameter_request_is_bounded(robot, predictor):
    request = SetParameters.Request(parameters=[
        Parameter('payload.mass', value=0.001 * k).to_parameter_msg() for k in range(2000)])
    begin = time.monotonic()
    answer = robot.call(SetParameters, 'set_parameters', request)
    print(f'{time.monotonic() - begin:.2f} s')
    assert len(answer.results) == 2000
    assert 100 <= sum(result.successful for result in answer.results) < 1000
    assert 'too many changes' in answer.results[-1].reason

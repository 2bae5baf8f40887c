"""Nothing that arrives ends a node: a callback that fails is logged, counted and skipped."""

import numpy as np
import pytest
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
import rclpy
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

NODES = ['torque_predictor', 'fake_baxter']
IMPOSSIBLE = SetParameters.Request(
    parameters=[Parameter(name='use_sim_time', value=ParameterValue(type=77))])


@pytest.fixture(params=NODES)
def node(request, robot, start):
    """Start a node with simulated time; return its name and its process."""
    if request.param == 'fake_baxter':
        pytest.importorskip('mujoco', reason='needs pip install ".[demo]"')
    return request.param, start(request.param, '-p', 'use_sim_time:=true')


def is_alive(robot, name):
    """Tell whether a node answers."""
    client = robot.create_client(GetParameters, f'/{name}/get_parameters')
    assert client.wait_for_service(15.0)
    future = client.call_async(GetParameters.Request(names=['arm']))
    rclpy.spin_until_future_complete(robot, future, timeout_sec=15.0)
    return future.done() and future.result().values[0].string_value == 'right'


def test_a_request_or_a_clock_that_fails_is_logged_and_the_node_goes_on(robot, node):
    name, process = node
    assert is_alive(robot, name)
    client = robot.create_client(SetParameters, f'/{name}/set_parameters')
    assert client.wait_for_service(15.0)
    client.call_async(IMPOSSIBLE)
    robot.until(lambda: 'a callback failed and was skipped (1 so far)' in process.output)
    assert 'ValueError' in process.output and '77' in process.output

    clock = robot.create_publisher(Clock, '/clock', 10)
    robot.until(lambda: clock.get_subscription_count())
    before = Clock()
    before.clock.sec = -1
    robot.spin(1.2)  # the log shows a failure a second
    robot.until(lambda: clock.publish(before) or '2 so far' in process.output)
    assert is_alive(robot, name)
    assert process.exit_code is None


def test_failures_are_counted_in_the_diagnostics(robot, predictor, sine):
    client = robot.create_client(SetParameters, '/torque_predictor/set_parameters')
    assert client.wait_for_service(15.0)
    client.call_async(IMPOSSIBLE)
    failed = 'a callback failed in the last second: ValueError'
    robot.until(lambda: any(status.message.startswith(failed)
                            for message in robot.diagnostics for status in message.status))
    level, _, values = robot.report()['callbacks']
    assert (level, values['failed']) == (b'\x00', '1')
    assert values['last failure'].startswith('ValueError: ')
    q, qd, _ = sine(np.arange(0.0, 0.5, 0.01))
    robot.stream(zip(q, qd, q))
    robot.until(lambda: robot.residual)


def test_a_name_that_is_no_text_costs_one_message(robot, predictor, sine):
    q, qd, _ = sine(np.arange(0.0, 0.5, 0.01))
    robot.stream(zip(q[:25], qd, q))
    robot.until(lambda: len(robot.predicted) == 25 - 21)
    raw = serialize_message(JointState(name=['left_s0'], position=[0.0]))
    robot.publisher.publish(raw.replace(b'left_s0', b'left\xff\xfe\xfd'))
    robot.stream(zip(q[25:], qd[25:], q[25:]), start=10 ** 18 + 250_000_000)
    robot.until(lambda: len(robot.predicted) == 50 - 21)


def test_missing_input_is_one_warning(robot, start):
    process = start('torque_predictor')
    robot.until(lambda: 'no joint states received' in process.output)
    robot.spin(2.0)
    assert process.output.count('[WARN]') == 1, process.output

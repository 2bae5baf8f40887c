"""Starting and ending of nodes: signals, failing callbacks, a middleware that locks up."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
import rclpy
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

NODES = pytest.mark.parametrize('executable', ['torque_predictor', 'fake_baxter'])
# rclpy raises for this type of value.
IMPOSSIBLE = SetParameters.Request(
    parameters=[Parameter(name='use_sim_time', value=ParameterValue(type=77))])


def needs_mujoco(executable):
    """Skip a test of the fake Baxter without MuJoCo."""
    if executable == 'fake_baxter':
        pytest.importorskip('mujoco', reason='needs pip install ".[demo]"')


@NODES
@pytest.mark.parametrize('by', [signal.SIGINT, signal.SIGTERM], ids=['SIGINT', 'SIGTERM'])
def test_ends_cleanly_on_a_signal(robot, start, executable, by):
    needs_mujoco(executable)
    process = start(executable)
    robot.until(lambda: '[INFO]' in process.output or process.exit_code is not None)
    robot.spin(0.2)
    assert process.end(by) == 0, process.output
    assert 'Traceback' not in process.output


def test_repeated_sigint_does_no_harm(robot, start):
    process = start('torque_predictor')  # ros2 launch may send a second one
    robot.until(lambda: '[INFO]' in process.output or process.exit_code is not None)
    limit = time.monotonic() + 10.0
    while process.exit_code is None and time.monotonic() < limit:
        os.kill(process.pid, signal.SIGINT)
        time.sleep(0.02)
    assert process.exit_code == 0, process.output
    assert 'Traceback' not in process.output


@NODES
def test_ends_in_the_middle_of_a_stream(robot, start, sine, executable):
    """A short version of 200 attempts each."""
    needs_mujoco(executable)
    remap = ['-r', '~/joint_torque_command:=/robot/joint_states', '-r',
             '/robot/joint_states:=/elsewhere'] if executable == 'fake_baxter' else []
    q, qd, _ = sine(np.arange(0.0, 1.0, 0.01))
    for attempt in range(2):
        process = start(executable, *remap)
        robot.until(lambda: robot.publisher.get_subscription_count() == 1)
        begin, k = time.monotonic(), 0
        while process.exit_code is None:
            robot.until(lambda: time.monotonic() > begin + 0.01 * k)
            robot.send_arm(10 ** 18 + k * 10_000_000, q[k % 100], qd[k % 100], [1.0] * 7)
            if k == 10 + attempt:
                os.kill(process.pid, signal.SIGTERM)
            k += 1
            assert time.monotonic() < begin + 20.0
        assert process.exit_code == 0, process.output
        robot.until(lambda: robot.publisher.get_subscription_count() == 0)


# Functions that make a node; each with the exit code and a part of stderr.
MADE = {
    # rclpy wakes executors first and ends the context next, so a wake-up may come too early.
    'signal woke the executor too early': ("""
def end_unnoticed():
    context = rclpy.get_default_context()
    with context.handle:
        context.handle.shutdown()

def make():
    threading.Timer(0.5, end_unnoticed).start()
    return Node('quiet')
""", 0, ''),
    'signal before the node is made': ("""
def make():
    rclpy.shutdown()  # as a signal does
    return Node('late')
""", 0, ''),
    'signal after the node is made': ("""
def make():
    node = Node('late')
    rclpy.shutdown()
    return node
""", 0, ''),
    'the middleware locks up at the end': ("""
def destroy_node():
    time.sleep(60.0)

def make():
    node = Node('locked')
    rclpy.shutdown()
    node.destroy_node = destroy_node
    return node

process._SHUTDOWN_LIMIT = 1.0
""", 1, 'destroy_node'),
}


@pytest.mark.parametrize('case', MADE)
def test_process_ends(domain, case):
    code, exit_code, err = MADE[case]
    done = subprocess.run(
        [sys.executable, '-c', 'import sys, threading, time\nimport rclpy\nfrom rclpy.node import '
         f'Node\nfrom baxter_dynamics_ros.nodes import process\n{code}\n'
         "sys.exit(process.run(make, 'name', ['name']))"],
        capture_output=True, text=True, timeout=20.0)
    assert done.returncode == exit_code and done.stdout == '', done.stderr
    assert err in done.stderr and bool(err) == bool(done.stderr)


def is_alive(robot, name):
    """Tell whether a node answers."""
    client = robot.create_client(GetParameters, f'/{name}/get_parameters')
    assert client.wait_for_service(15.0)
    future = client.call_async(GetParameters.Request(names=['arm']))
    rclpy.spin_until_future_complete(robot, future, timeout_sec=15.0)
    return future.done() and future.result().values[0].string_value == 'right'


@NODES
def test_failing_callbacks_are_logged_and_the_node_continues(robot, start, executable):
    needs_mujoco(executable)
    process = start(executable, '-p', 'use_sim_time:=true')
    assert is_alive(robot, executable)
    client = robot.create_client(SetParameters, f'/{executable}/set_parameters')
    assert client.wait_for_service(15.0)
    client.call_async(IMPOSSIBLE)
    robot.until(lambda: 'a callback failed and was skipped (1 so far)' in process.output)
    assert 'ValueError' in process.output and '77' in process.output
    if executable == 'torque_predictor':
        failed = 'a callback failed in the last second: ValueError'
        robot.until(lambda: any(each['callbacks'][1].startswith(failed)
                                for each in robot.statuses()))
        level, _, values = robot.report()['callbacks']
        assert (level, values['failed']) == (b'\x00', '1')
        assert values['last failure'].startswith('ValueError: ')

    clock = robot.create_publisher(Clock, '/clock', 10)
    robot.until(lambda: clock.get_subscription_count())
    before = Clock()
    before.clock.sec = -1
    robot.spin(1.1)  # the log shows a failure a second
    robot.until(lambda: clock.publish(before) or '2 so far' in process.output)
    assert is_alive(robot, executable)
    assert process.exit_code is None


def test_a_name_that_is_no_text_costs_one_message(robot, predictor, sine):
    q, qd, _ = sine(np.arange(0.0, 0.5, 0.01))
    robot.stream(zip(q[:25], qd, q))
    robot.until(lambda: len(robot.predicted) == 25 - 21)
    raw = serialize_message(JointState(name=['left_s0'], position=[0.0]))
    robot.publisher.publish(raw.replace(b'left_s0', b'left\xff\xfe\xfd'))
    robot.stream(zip(q[25:], qd[25:], q[25:]), start=10 ** 18 + 250_000_000)
    robot.until(lambda: len(robot.predicted) == 50 - 21)

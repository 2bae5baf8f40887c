"""Starting and ending of nodes: signals, failing callbacks, a middleware that locks up."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
from perfect_robot import trajectory
import pytest
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

# Arguments with which each node subscribes to the joint states of the test.
NODES = {'torque_predictor': [],
         'fake_baxter': ['-r', '~/joint_torque_command:=/robot/joint_states', '-r',
                         '/robot/joint_states:=/elsewhere']}
# rclpy raises for this type of value.
IMPOSSIBLE = SetParameters.Request(
    parameters=[Parameter(name='use_sim_time', value=ParameterValue(type=77))])


def test_a_name_that_is_no_text_costs_one_message(robot, predictor):
    q, qd, _ = trajectory(np.arange(0.0, 0.5, 0.01))
    robot.stream(zip(q[:25], qd, q))
    robot.until(lambda: len(robot.predicted) == 25 - 21)
    raw = serialize_message(JointState(name=['left_s0'], position=[0.0]))
    robot.publisher.publish(raw.replace(b'left_s0', b'left\xff\xfe\xfd'))
    robot.stream(zip(q[25:], qd[25:], q[25:]), start=10 ** 18 + 250_000_000)
    robot.until(lambda: len(robot.predicted) == 50 - 21)


def test_ends_cleanly_on_repeated_sigint(robot, predictor):
    limit = time.monotonic() + 20.0
    while predictor.poll() is None and time.monotonic() < limit:
        os.kill(predictor.pid, signal.SIGINT)  # ros2 launch may send a second one
        time.sleep(0.02)
    assert predictor.poll() == 0, predictor.output
    assert 'Traceback' not in predictor.output


@pytest.mark.parametrize('executable', NODES)
def test_ends_in_the_middle_of_a_stream(robot, start, executable):
    if executable == 'fake_baxter':
        pytest.importorskip('mujoco', reason='needs pip install ".[demo]"')
    q, qd, _ = trajectory(np.arange(0.0, 1.0, 0.01))
    process = start(executable, *NODES[executable])
    robot.until(lambda: robot.publisher.get_subscription_count() == 1)
    k = 0
    while process.poll() is None:
        robot.send_arm(10 ** 18 + k * 10_000_000, q[k % 100], qd[k % 100], [1.0] * 7)
        if k == 20:
            os.kill(process.pid, signal.SIGTERM)
        robot.spin(0.005)
        k += 1
        assert k < 4000
    assert process.poll() == 0 and 'Traceback' not in process.output, process.output
    robot.until(lambda: robot.publisher.get_subscription_count() == 0)


# Runs functions that make a node, and prints the exit codes.
ENDINGS = """
import sys, threading, time
import rclpy
from rclpy.node import Node
from baxter_dynamics_ros.nodes import process

# rclpy wakes executors first and ends the context next, so a wake-up may come too early.
def signal_wakes_the_executor_too_early():
    def end_unnoticed():
        context = rclpy.get_default_context()
        with context.handle:
            context.handle.shutdown()
    threading.Timer(0.5, end_unnoticed).start()
    return Node('quiet')

def signal_before_the_node_is_made():
    rclpy.shutdown()
    return Node('late')

def signal_after_the_node_is_made():
    node = Node('late')
    rclpy.shutdown()
    return node

def middleware_locks_up_at_the_end():
    def destroy_node():
        time.sleep(60.0)
    node = Node('locked')
    rclpy.shutdown()
    node.destroy_node = destroy_node
    return node

if sys.argv[1:]:
    process._SHUTDOWN_LIMIT = 1.0
    process.run(middleware_locks_up_at_the_end, 'name', ['name'])
for make in (signal_before_the_node_is_made, signal_after_the_node_is_made,
             signal_wakes_the_executor_too_early):
    print(process.run(make, 'name', ['name']), flush=True)
"""


def test_process_ends_whenever_a_signal_comes(domain):
    done, locked = (subprocess.run(
        [sys.executable, '-c', ENDINGS, *arguments], capture_output=True, text=True, timeout=60.0)
        for arguments in ([], ['locked']))
    assert (done.returncode, done.stdout.split(), done.stderr) == (0, ['0', '0', '0'], '')
    assert locked.returncode == 1 and 'destroy_node' in locked.stderr


def test_failing_callbacks_are_logged_and_the_node_continues(robot, start):
    process = start('torque_predictor', '-p', 'use_sim_time:=true')
    assert robot.parameters()['arm'] == 'right'
    client = robot.create_client(SetParameters, '/torque_predictor/set_parameters')
    assert client.wait_for_service(30.0)
    client.call_async(IMPOSSIBLE)
    robot.until(lambda: 'a callback failed and was skipped (1 so far)' in process.output)
    assert 'ValueError' in process.output and '77' in process.output
    failed = 'a callback failed in the last second: ValueError'
    robot.until(lambda: failed in str([each['callbacks'] for each in robot.statuses()]))
    level, _, values = robot.report()['callbacks']
    assert (level, values['failed']) == (b'\x00', '1')
    assert values['last failure'].startswith('ValueError: ')

    clock = robot.create_publisher(Clock, '/clock', 10)
    robot.until(lambda: clock.get_subscription_count())
    before = Clock()
    before.clock.sec = -1
    robot.spin(1.1)  # the log shows a failure a second
    robot.until(lambda: clock.publish(before) or '2 so far' in process.output)
    assert robot.parameters()['arm'] == 'right'
    assert process.poll() is None

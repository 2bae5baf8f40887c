"""Starting and ending: signals, missing optional packages, a name of one's own."""

import os
from pathlib import Path
import signal
import subprocess
import sys
from threading import Timer
import time

from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.process import run
import numpy as np
import pytest
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState


STREAM = 100  # [Hz]
RELAY = [sys.executable, str(Path(__file__).parents[2] / 'benchmarks' / 'relay.py')]


def exit_code(process):
    """Return a process's exit code; None while it runs."""
    return process.poll() if isinstance(process, subprocess.Popen) else process.exit_code


@pytest.fixture
def start_relay(domain):
    """Return a function that starts the benchmark's relay; all have ended with the test."""
    processes = []

    def start_():
        processes.append(subprocess.Popen(RELAY, stdin=subprocess.DEVNULL))
        return processes[-1]
    yield start_
    for process in processes:
        process.kill()
        process.wait()


@pytest.mark.parametrize('executable', ['torque_predictor', 'fake_baxter'])
@pytest.mark.parametrize('by', [signal.SIGINT, signal.SIGTERM], ids=['SIGINT', 'SIGTERM'])
def test_ends_cleanly_on_a_signal(robot, start, executable, by):
    if executable == 'fake_baxter':
        pytest.importorskip('mujoco', reason='needs pip install ".[demo]"')
    process = start(executable)
    robot.until(lambda: '[INFO]' in process.output or process.exit_code is not None)
    robot.spin(0.5)
    assert process.end(by) == 0, process.output
    assert 'Traceback' not in process.output


def test_one_sigint_after_another_does_no_harm(robot, start):
    process = start('torque_predictor')  # ros2 launch may send a second one
    robot.until(lambda: '[INFO]' in process.output or process.exit_code is not None)
    limit = time.monotonic() + 10.0
    while process.exit_code is None and time.monotonic() < limit:
        os.kill(process.pid, signal.SIGINT)
        time.sleep(0.02)
    assert process.exit_code == 0, process.output
    assert 'Traceback' not in process.output


@pytest.mark.parametrize('executable', ['torque_predictor', 'fake_baxter', 'relay'])
def test_ends_in_the_middle_of_a_stream(robot, start, start_relay, sine, executable):
    """A short version of 200 attempts each."""
    remap = ['-r', '~/joint_torque_command:=/robot/joint_states', '-r',
             '/robot/joint_states:=/elsewhere'] if executable == 'fake_baxter' else []
    q, qd, _ = sine(np.arange(0.0, 1.0, 0.01))
    for attempt in range(3):
        process = start_relay() if executable == 'relay' else start(executable, *remap)
        robot.until(lambda: robot.publisher.get_subscription_count() == 1)
        begin, k = time.monotonic(), 0
        while exit_code(process) is None:
            robot.until(lambda: time.monotonic() > begin + k / STREAM)
            robot.send_arm(10 ** 18 + k * 10_000_000, q[k % 100], qd[k % 100], [1.0] * 7)
            if k == 10 + attempt:
                os.kill(process.pid, signal.SIGTERM)
            k += 1
            assert time.monotonic() < begin + 20.0
        assert exit_code(process) == 0, getattr(process, 'output', '')
        robot.until(lambda: robot.publisher.get_subscription_count() == 0)


def test_ends_even_if_the_signal_woke_the_executor_too_early(domain):
    """On a signal, rclpy wakes executors first and ends the context next."""
    def end_unnoticed():
        context = rclpy.get_default_context()
        with context.handle:
            context.handle.shutdown()  # as its thread does, after the wake-up was used

    timer = Timer(1.0, end_unnoticed)
    timer.start()
    begin = time.monotonic()
    try:
        assert run(lambda: Node('quiet'), 'quiet', ['quiet']) == 0
    finally:
        rclpy.try_shutdown()
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
    assert time.monotonic() - begin < 20.0
    timer.join()


def test_without_the_service_types_topics_work_and_the_log_says_how(robot, start, tmp_path, sine):
    hidden = tmp_path / 'baxter_dynamics_interfaces'
    hidden.mkdir()
    (hidden / '__init__.py').write_text('raise ImportError("not installed")\n')
    path = os.pathsep.join([str(tmp_path), os.environ.get('PYTHONPATH', '')])
    process = start('torque_predictor', PYTHONPATH=path)
    robot.wait_for_node()
    q, qd, _ = sine(np.arange(0.0, 0.6, 0.01))
    robot.stream([(a, b, [1.0] * 7) for a, b in zip(q, qd)])
    robot.until(lambda: robot.residual)
    assert 'pip install ./baxter_dynamics_interfaces' in process.output
    services = [name for name, _ in robot.get_service_names_and_types()]
    assert '/torque_predictor/reset' in services
    assert '/torque_predictor/gravity_torques' not in services


def test_topics_can_be_remapped(robot, start, sine):
    publisher = robot.create_publisher(JointState, '/sim/joint_states', topics.PUBLISHER_QOS)
    start('torque_predictor', '-r', '/robot/joint_states:=/sim/joint_states')
    robot.until(lambda: publisher.get_subscription_count() == 1)


def test_console_script_lists_its_options():
    result = subprocess.run([sys.executable, '-m', 'baxter_dynamics_ros.cli.main', '--help'],
                            capture_output=True, text=True, timeout=30)
    assert result.returncode == 0
    assert 'demo' in result.stdout


@pytest.mark.parametrize('when', ['before', 'after'])
def test_a_signal_while_the_node_is_made_ends_it_in_silence(domain, capfd, when):
    def make():
        node = Node('late') if when == 'after' else None
        rclpy.shutdown()  # as a signal does
        return node or Node('late')
    assert run(make, 'late', ['late']) == 0
    assert capfd.readouterr() == ('', '')


LOCKED = """
import time
import rclpy
from rclpy.node import Node
from baxter_dynamics_ros.nodes import process

class Locked(Node):
    def destroy_node(self):
        time.sleep(60.0)

def make():
    node = Locked('locked')
    rclpy.shutdown()  # as a signal does
    return node

process._END_WITHIN = 1.0
process.run(make, 'locked', ['locked'])
"""


def test_ends_even_if_the_middleware_locks_up_at_the_end(domain):
    done = subprocess.run([sys.executable, '-c', LOCKED], capture_output=True, text=True,
                          timeout=40.0)
    assert done.returncode == 1
    assert 'destroy_node' in done.stderr

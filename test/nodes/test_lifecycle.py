"""Starting and ending: signals, missing optional packages, a name of one's own."""

import os
import signal
import subprocess
import sys
import time

from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.process import run
import numpy as np
import pytest
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState


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


@pytest.mark.parametrize('attempt', range(3))
def test_ends_cleanly_in_the_middle_of_a_fast_stream(robot, start_predictor, sine, attempt):
    process = start_predictor()
    q, qd, _ = sine(np.arange(0.0, 1.0, 0.001))
    for k in range(1000):
        robot.send_arm(10 ** 18 + k * 1_000_000, q[k], qd[k], [1.0] * 7)
        if k == 800:
            os.kill(process.pid, signal.SIGTERM)
    assert process.wait(10.0) == 0, process.output
    assert 'Traceback' not in process.output


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

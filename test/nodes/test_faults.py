"""Recovery of the node when processes beside it are killed, stopped or wrong."""

from contextlib import contextmanager
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import time

from baxter_dynamics_ros.model.joints import joint_names
from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.messages import joint_state
import numpy as np
import pytest
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

PERIOD = 10_000_000  # [ns]
SETTLING = 22  # joint states at 100 Hz for which the filter settles, at most
RESIDUAL = '/torque_predictor/effort_residual'
OK = b'\x00'
WARN = b'\x01'
STALE = b'\x03'


class Motion:
    """A robot that moves with even stamps, whatever happens to other processes meanwhile."""

    def __init__(self, robot):
        from perfect_robot import rows  # which the processes of this file do not find
        self.rows = rows(0.01 * np.arange(6000))
        self._robot = robot
        self._start_ns = None
        self.sent = 0

    def until(self, condition):
        """Move until a condition holds; fail when it does not in time."""
        limit = time.monotonic() + 30.0
        while not condition():
            assert time.monotonic() < limit, 'nothing within 30 s'
            if self._start_ns is None:  # at a whole number of periods: others keep clear of these
                self._start_ns = (time.time_ns() // PERIOD + 1) * PERIOD
            stamp = self._start_ns + self.sent * PERIOD
            self._robot.until(lambda: time.time_ns() >= stamp)
            self._robot.send_arm(stamp, *self.rows[self.sent])
            self.sent += 1

    def run(self, seconds):
        """Move for a while."""
        end = self.sent + round(seconds * 1e9 / PERIOD)
        self.until(lambda: self.sent >= end)


@pytest.fixture
def motion(robot):
    """Return a robot in motion at 100 Hz."""
    return Motion(robot)


@pytest.fixture
def helper(domain):
    """Return a function that runs a function of this file in a process; all end with the test."""
    processes = []

    def run(name):
        processes.append(subprocess.Popen(
            [sys.executable, __file__, name], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            text=True))
        return processes[-1]
    yield run
    for process in processes:
        process.kill()
        process.communicate()


@contextmanager
def stopped(process):
    """Stop a process for a while; it does not notice."""
    os.kill(process.pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(process.pid, signal.SIGCONT)


def kill(process):
    """Kill a process, and remove the shared memory that it leaves."""
    held = [path.resolve() for path in Path(f'/proc/{process.pid}/fd').iterdir()]
    os.kill(process.pid, signal.SIGKILL)
    process.wait(5.0)
    for lock in held:
        if re.fullmatch('/dev/shm/fastrtps_[0-9a-f]{16}_el', str(lock)):
            lock.unlink()
            lock.with_name(lock.name.removesuffix('_el')).unlink()


def reported(robot, name, level):
    """Return all messages of a status so far that had a level."""
    return [status[name][1] for status in robot.statuses() if status[name][0] == level]


def assert_right(messages):
    """Assert that residuals are those of a robot whose every effort is modelled."""
    residual = np.array([message.effort for message in messages])
    assert np.abs(residual).max() < 0.15, residual


def unpredicted(report):
    """Return how many joint states of the arm the node has heard but predicted nothing for."""
    heard, running = report['input'][2], report['filter'][2]
    return int(heard['received']) - int(heard['not_this_arm']) - int(running['predicted'])


def resets(report):
    """Return how often the filter started anew, by reason."""
    return {key: int(n) for key, n in report['filter'][2].items()
            if key.startswith('reset_') and n != '0'}


def is_well(robot):
    """Tell whether the newest diagnostics find nothing wrong."""
    return bool(robot.diagnostics) and all(
        status.level == OK for status in robot.diagnostics[-1].status)


def test_a_node_that_is_stopped_for_a_second_loses_nothing(robot, predictor, motion, stamps):
    motion.run(0.3)
    with stopped(predictor):
        motion.run(1.2)
    motion.run(0.3)
    robot.until(lambda: len(robot.residual) >= motion.sent - 21)
    assert len(robot.residual) == motion.sent - 21
    assert set(np.diff(stamps(robot.residual))) == {PERIOD}
    assert_right(robot.residual)
    assert set(resets(robot.report())) <= {'reset_requested'}


def test_a_stopped_subscriber_delays_nobody(robot, predictor, motion, stamps, helper):
    listener = helper('listen')
    robot.until(lambda: robot.count_subscribers(RESIDUAL) == 2)
    motion.run(0.3)
    robot.until(lambda: len(robot.residual) == motion.sent - 21)
    robot.call(Trigger, 'reset')
    robot.residual.clear()
    with stopped(listener):
        robot.stream(motion.rows[:800])  # more messages than shared memory keeps for a reader
        robot.until(lambda: len(robot.residual) == 800 - 21)
    assert set(np.diff(stamps(robot.residual))) == {PERIOD}
    assert_right(robot.residual)


def test_a_flood_of_requests_costs_no_joint_state(robot, predictor, motion, stamps, helper):
    pytest.importorskip('baxter_dynamics_interfaces.srv')
    clients = helper('flood')
    assert clients.stdout.readline() == 'flooding\n'
    robot.stream(motion.rows[:150], pace=0.01)
    robot.until(lambda: len(robot.residual) == 150 - 21)
    assert set(np.diff(stamps(robot.residual))) == {PERIOD}
    assert int(clients.stdout.readline()) > 0, 'no flood'


def test_a_second_publisher_is_reported(robot, predictor, motion, helper):
    twin = robot.create_publisher(JointState, RESIDUAL, 10)
    motion.until(lambda: 'a second predictor' in str(reported(robot, 'residual', WARN)))
    robot.destroy_publisher(twin)
    other = helper('publish_zeros')
    motion.until(lambda: any('a second publisher on the topic' in message for name in (
        'input', 'filter') for message in reported(robot, name, WARN)))
    kill(other)

    count = len(robot.residual)
    motion.until(lambda: len(robot.residual) > count)
    robot.diagnostics.clear()
    motion.until(lambda: is_well(robot))
    # The other's arm may be predicted when this process pauses, but never a mixture of both.
    assert_right([message for message in robot.residual if np.any(message.position)])


def test_a_publisher_may_stop_die_and_come_back(robot, start, stamps):
    pytest.importorskip('mujoco', reason='needs pip install ".[demo]"')
    robot.start_predictor('-p', 'payload.mass:=0.01')  # so that its counts are those of this test
    baxter = start('fake_baxter')
    robot.until(lambda: len(robot.residual) > 20)

    def predicts_again(since):  # a message that got lost may come 3 s late
        return max(stamps(robot.residual), default=0) > since
    robot.diagnostics.clear()
    with stopped(baxter):
        robot.until(lambda: 'no joint states received' in str(reported(robot, 'input', STALE)))
        robot.residual.clear()
        continued = time.time_ns()
    robot.until(lambda: predicts_again(continued))

    kill(baxter)
    robot.residual.clear()
    killed = time.time_ns()
    start('fake_baxter')
    robot.until(lambda: predicts_again(killed))
    report = robot.report()
    since = resets(report)
    assert set(since) == {'reset_gap'} and since['reset_gap'] >= 2
    assert unpredicted(report) <= SETTLING * (2 + since['reset_gap'])
    robot.until(lambda: is_well(robot))
    assert np.isfinite([message.effort for message in robot.predicted + robot.residual]).all()


def test_a_killed_node_predicts_again_within_a_second(robot, start, motion, stamps):
    first = start('torque_predictor')
    motion.until(lambda: robot.residual)
    kill(first)
    robot.residual.clear()

    killed = time.time_ns()
    start('torque_predictor')
    motion.until(lambda: max(stamps(robot.residual), default=0) > killed)
    motion.run(0.3)
    assert_right(robot.residual)
    assert unpredicted(robot.report()) <= SETTLING


def listen():
    """Subscribe to the residual with a short queue, reliably."""
    node = Node('listener')
    node.create_subscription(JointState, RESIDUAL, lambda message: None, 1)
    rclpy.spin(node)


def publish_zeros():
    """Publish joint states of another posture, half a period beside the robot's."""
    node = Node('another_robot')
    publisher = node.create_publisher(JointState, topics.JOINT_STATES, 10)
    names = joint_names('right')
    while True:
        stamp = (time.time_ns() // 10_000_000 + 1) * 10_000_000 + 5_000_000
        time.sleep(max(0.0, (stamp - time.time_ns()) * 1e-9))
        publisher.publish(joint_state(names, stamp, np.zeros(7), np.zeros(7), np.ones(7)))


def flood():
    """Send requests of eight clients for 1.2 s, each as soon as it has an answer."""
    from baxter_dynamics_interfaces import srv
    node = Node('clients', start_parameter_services=False)
    state = joint_state(joint_names('right'), 1, *np.full((2, 7), 0.3))
    answers = []

    def ask(client):
        future = client.call_async(client.srv_type.Request(state=state))
        future.add_done_callback(lambda future: (answers.append(future.result().success),
                                                 ask(client)))
    for kind, name in 4 * ((srv.GravityTorques, 'gravity_torques'),
                           (srv.InverseDynamics, 'inverse_dynamics')):
        client = node.create_client(kind, f'/torque_predictor/{name}')
        client.wait_for_service(30.0)
        ask(client)
    while len(answers) < 8:
        rclpy.spin_once(node)
    print('flooding', flush=True)
    end, before = time.monotonic() + 1.2, len(answers)
    while time.monotonic() < end:
        rclpy.spin_once(node)
    assert all(answers)
    print(len(answers) - before, flush=True)


if __name__ == '__main__':
    rclpy.init()
    {'listen': listen, 'publish_zeros': publish_zeros, 'flood': flood}[sys.argv[1]]()

"""
Run the node and the stream handler for long: is memory flat, is anything lost, is latency flat.

The node is sent messages at 1000 Hz, or as fast as the machine lets it, over reliable connections;
the stream handler takes the rest of them, as fast as it can. Run: python benchmarks/soak.py
[--messages 1000000] [--node-seconds 60]
"""

import argparse
import os
import time
from typing import NamedTuple

from baxter_dynamics_ros.cli.processes import NodeProcess
from baxter_dynamics_ros.estimation.events import DROPPED
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.messages import joint_state, stamp_ns
from baxter_dynamics_ros.simulation.robot import JOINT_STATE_NAMES
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from usage import memory, processor_time

RATE = 1000  # [Hz]
PERIOD = 1_000_000_000 // RATE  # [ns]
START = 10 ** 18  # [ns]
CYCLE = 4000  # messages after which the motion repeats
WARM = 0.2  # of the messages come before memory is looked at for the first time
PARTS = 10
AHEAD = 50  # messages that may be on their way to the node and back: fewer than any queue holds
PATIENCE = 20.0  # [s]
RELIABLE = ['-p', f'qos_overrides.{topics.JOINT_STATES}.subscription.reliability:=reliable']


class Soak(NamedTuple):
    """What became of the messages that were sent, and what the run was like."""

    sent: int
    received: int
    dropped: int
    predicted: int
    residuals: int  # that arrived
    quiet: int  # messages at the beginning that give no prediction: the filter settles
    seconds: float  # that it took [s]
    memory: tuple  # resident, once warm and in the end [MB]
    latency: np.ndarray  # p99 of each tenth of the messages (10,) [ms]
    processor: np.ndarray  # processor time a message of each tenth (10,) [ms]

    @property
    def growth(self) -> float:
        """Of memory [MB]."""
        return self.memory[1] - self.memory[0]

    @property
    def slowing(self) -> float:
        """Return the processor time of the last tenths over that of the second to fourth."""
        return float(np.median(self.processor[-3:]) / np.median(self.processor[1:4]))

    @property
    def lost(self) -> int:
        """Messages that were not received, taken and answered by a residual each."""
        return sum(abs(n) for n in (
            self.sent - self.received, self.dropped, self.sent - self.quiet - self.predicted,
            self.predicted - self.residuals))


class Wires(Node):
    """
    The other end: publishes joint states, and takes the residuals and the diagnostics.

    Attributes
    ----------
    arrived : list
        Stamp [ns] and time of arrival [s] of the residuals.
    reports : list
        The diagnostics, key to value.

    """

    def __init__(self):
        super().__init__('soak')
        self.publisher = self.create_publisher(JointState, topics.JOINT_STATES, 1000)
        self.arrived, self.reports = [], []
        self.residual = topics.below_node(topics.EFFORT_RESIDUAL).replace('~', '/torque_predictor')
        self.create_subscription(JointState, self.residual, lambda message: self.arrived.append(
            (stamp_ns(message.header), time.perf_counter())), 1000)
        self.create_subscription(
            DiagnosticArray, topics.DIAGNOSTICS, lambda message: self.reports.append(
                {pair.key: pair.value for status in message.status for pair in status.values}), 9)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self)

    def spin(self, seconds: float):
        """Let one message come in, if there is one within the time."""
        self._executor.spin_once(seconds)

    def until(self, condition, what: str):
        """Let messages come in until a condition holds."""
        limit = time.monotonic() + PATIENCE
        while not condition():
            self.spin(0.05)
            if time.monotonic() > limit:
                raise RuntimeError(f'{what} within {PATIENCE:g} s')


def messages(n: int):
    """Yield stamp [ns], position, velocity and effort (17,) of n messages of a smooth motion."""
    speed = 2 * np.pi * RATE / CYCLE  # [rad/s]
    phase = speed / RATE * np.arange(CYCLE)[:, None] + np.arange(len(JOINT_STATE_NAMES))
    rows = list(zip(0.4 * np.sin(phase), 0.4 * speed * np.cos(phase), 5.0 * np.cos(phase)))
    for k in range(n):
        yield START + k * PERIOD, *rows[k % CYCLE]


def through_handler(n: int) -> Soak:
    """Send n messages to a stream handler; latency is its processor time for each."""
    predictor = PredictorSettings().predictor(external=True)
    spent = np.full(n, np.nan)  # [s]
    residuals, begin = 0, time.perf_counter()
    for k, message in enumerate(messages(n)):
        if k == round(WARM * n):
            before = resident()
        started = time.thread_time()
        step = predictor.handle(message[0], JOINT_STATE_NAMES, *message[1:])
        if step.external is not None:
            predictor.external.wrench(step.external)
        spent[k] = time.thread_time() - started
        residuals += step.prediction is not None and step.prediction.residual is not None
    counts = predictor.counts
    return Soak(n, counts['received'], sum(counts[event] for event in DROPPED),
                counts['predicted'], residuals, quiet_messages(), time.perf_counter() - begin,
                (before, resident()), p99(spent),
                np.array([part.mean() for part in np.array_split(spent, PARTS)]) * 1e3)


def through_node(n: int) -> Soak:
    """Send n messages to a node; latency is from publishing a joint state to its residual."""
    rclpy.init(args=[])
    wires = Wires()
    try:
        with NodeProcess('torque_predictor', ['--ros-args', *RELIABLE]) as process:
            wires.until(lambda: wires.publisher.get_subscription_count()
                        and wires.count_publishers(wires.residual), 'no node')
            begin = time.perf_counter()
            sent, before, used = _send(wires, n, process.pid)
            seconds = time.perf_counter() - begin
            wires.reports.clear()  # the last answers arrive before the second, or are lost
            wires.until(lambda: len(wires.reports) >= 2, 'no two diagnostics')
            memory = before, resident(process.pid)
    finally:
        wires.destroy_node()
        rclpy.try_shutdown()
    behind = round(PredictorSettings().predictor().estimator.delay * 1e9)
    latency = np.full(n, np.nan)  # [s]
    for stamp, when in wires.arrived:
        k = (stamp + behind - START) // PERIOD
        latency[k] = when - sent[k]
    counts = wires.reports[-1]
    return Soak(n, int(counts['received']), sum(int(counts[event.value]) for event in DROPPED),
                int(counts['predicted']), len(wires.arrived), quiet_messages(), seconds, memory,
                p99(latency), np.diff(used) / (n / PARTS) * 1e3)


def _send(wires: Wires, n: int, pid: int) -> tuple:
    """
    Send n messages.

    Returns
    -------
    tuple
        When each was sent (n,) [s], the node's memory once warm [MB], and the processor time it
        has used by the beginning of each tenth and by the end (11,) [s].

    """
    sent, quiet, used = np.full(n, np.nan), quiet_messages(), []
    begin = time.perf_counter()
    for k, (stamp, *fields) in enumerate(messages(n)):
        if k == round(WARM * n):
            before = resident(pid)
        if k % (n // PARTS) == 0:
            used.append(processor_time(pid))
        while (left := begin + k / RATE - time.perf_counter()) > 0.0:
            wires.spin(left)
        if k - quiet - len(wires.arrived) >= AHEAD:
            wires.until(lambda: k - quiet - len(wires.arrived) < AHEAD, f'no answer to {k}')
        message = joint_state(JOINT_STATE_NAMES, stamp, *fields)
        sent[k] = time.perf_counter()
        wires.publisher.publish(message)
    return sent, before, [*used, processor_time(pid)][:PARTS + 1]


def quiet_messages() -> int:
    """Return how many messages give no prediction, for the filter settles."""
    predictor = PredictorSettings().predictor()
    return next(k for k, (stamp, *fields) in enumerate(messages(CYCLE))
                if predictor.handle(stamp, JOINT_STATE_NAMES, *fields).prediction is not None)


def p99(seconds: np.ndarray) -> np.ndarray:
    """Return the 99th percentile of each tenth (10,) [ms]; what is NaN does not count."""
    return np.array([np.nanpercentile(part, 99) for part in np.array_split(seconds, PARTS)]) * 1e3


def resident(pid='self') -> float:
    """Return the memory that a process has in use [MB]."""
    return memory(pid=pid) / 2 ** 20


def main():
    """Print one table."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--messages', type=int, default=1_000_000)
    parser.add_argument('--node-seconds', type=float, default=60.0)
    options = parser.parse_args()
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ.setdefault('ROS_DOMAIN_ID', '94')
    to_node = min(round(options.node_seconds * RATE), options.messages)
    runs = {'node': through_node(to_node)}
    if to_node < options.messages:
        runs['handler'] = through_handler(options.messages - to_node)
    rows = {
        'messages sent': lambda run: run.sent,
        'received': lambda run: run.received,
        'dropped': lambda run: run.dropped,
        'predicted, all but the first': lambda run: f'{run.predicted} ({run.quiet})',
        'residuals': lambda run: run.residuals,
        'lost': lambda run: run.lost,
        'messages a second': lambda run: round(run.sent / run.seconds),
        'memory, warm [MB]': lambda run: f'{run.memory[0]:.1f}',
        'memory, in the end [MB]': lambda run: f'{run.memory[1]:.1f}',
        'growth [MB]': lambda run: f'{run.growth:+.1f}',
        'processor time, last / first': lambda run: f'{run.slowing:.2f}'}
    print(f'{"":30}' + ''.join(f'{name:>16}' for name in runs))
    for name, value in rows.items():
        print(f'{name:30}' + ''.join(f'{value(run)!s:>16}' for run in runs.values()))
    for k in range(PARTS):
        print(f'{f"p99 of tenth {k + 1} [ms]":30}' + ''.join(
            f'{run.latency[k]:16.3f}' for run in runs.values()))


if __name__ == '__main__':
    main()

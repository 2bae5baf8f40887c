"""
Soak test of the node: no losses, constant memory and processor time.

The node receives messages at 1000 Hz or as fast as it responds, over reliable connections.
Run: python benchmarks/soak.py [--messages 1000000]
"""

import argparse
import time
from typing import NamedTuple

from baxter_dynamics_ros.cli.processes import NodeProcess
from baxter_dynamics_ros.estimation.events import DROPPED
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.messages import joint_state
from baxter_dynamics_ros.simulation.robot import JOINT_STATE_NAMES
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from processes import costs, isolate, spin
import rclpy
from sensor_msgs.msg import JointState

RATE = 1000  # [Hz]
START = 10 ** 18  # [ns]
CYCLE = 4000  # messages after which the motion repeats
PARTS = 10  # number of parts for which processor time is measured
WARM = 2  # number of parts before the first memory measurement
AHEAD = 50  # maximum number of pending messages, below the depth of every queue
PATIENCE = 20.0  # [s]
RELIABLE = ['-p', f'qos_overrides.{topics.JOINT_STATES}.subscription.reliability:=reliable']


class Soak(NamedTuple):
    """Counts and costs of a run."""

    sent: int
    received: int
    dropped: int
    predicted: int
    residuals: int  # that arrived
    quiet: int  # initial messages without a prediction, while the filter settles
    growth: float  # increase of resident memory after WARM parts [MB]
    processor: np.ndarray  # processor time per message of each part (10,) [ms]

    @property
    def lost(self) -> int:
        """Messages without a residual after the first prediction."""
        return self.sent - self.quiet - self.residuals


def messages(n: int):
    """Yield stamp [ns], position, velocity and effort (17,) of n messages of a smooth motion."""
    speed = 2 * np.pi * RATE / CYCLE  # [rad/s]
    phase = speed / RATE * np.arange(CYCLE)[:, None] + np.arange(len(JOINT_STATE_NAMES))
    rows = list(zip(0.4 * np.sin(phase), 0.4 * speed * np.cos(phase), 5.0 * np.cos(phase)))
    for k in range(n):
        yield START + k * 10 ** 9 // RATE, *rows[k % CYCLE]


def through_node(n: int) -> Soak:
    """Send n messages to a node, and count the residuals and the diagnostics that come back."""
    predictor = Predictor(PredictorSettings())
    quiet = next(k for k, (stamp, *fields) in enumerate(messages(CYCLE))
                 if predictor.handle(stamp, JOINT_STATE_NAMES, *fields).prediction is not None)
    rclpy.init(args=[])
    node, residuals, reports = rclpy.create_node('soak'), [], []
    publisher = node.create_publisher(JointState, topics.JOINT_STATES, 1000)
    topic = f'/torque_predictor/{topics.EFFORT_RESIDUAL}'
    node.create_subscription(JointState, topic, lambda message: residuals.append(1), 1000)
    node.create_subscription(
        DiagnosticArray, topics.DIAGNOSTICS, lambda message: reports.append(
            {pair.key: pair.value for status in message.status for pair in status.values}), 9)

    def until(condition, what: str):
        if not spin(node, PATIENCE, condition):
            raise RuntimeError(f'{what} within {PATIENCE:g} s')
    try:
        with NodeProcess('torque_predictor', ['--ros-args', *RELIABLE]) as process:
            # The node has found all subscriptions when its diagnostics arrive.
            until(lambda: publisher.get_subscription_count() and reports, 'no node')
            spent, begin = [], time.perf_counter()
            for k, (stamp, *fields) in enumerate(messages(n)):
                if k % (n // PARTS) == 0:
                    spent.append(costs(process.pid))
                spin(node, begin + k / RATE - time.perf_counter())
                until(lambda: k - quiet - len(residuals) < AHEAD, f'no answer to {k}')
                publisher.publish(joint_state(JOINT_STATE_NAMES, stamp, *fields))
            reports.clear()  # the last residuals arrive before the second report, or are lost
            until(lambda: len(reports) >= 2, 'no two diagnostics')
            spent.append(costs(process.pid))
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    report, (used, memory) = reports[-1], np.transpose(spent)
    return Soak(n, int(report['received']), sum(int(report[event.value]) for event in DROPPED),
                int(report['predicted']), len(residuals), quiet, memory[-1] - memory[WARM],
                np.diff(used) / (n // PARTS) * 1e3)


def main():
    """Print the counts and costs."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--messages', type=int, default=1_000_000)
    options = parser.parse_args()
    isolate(94)
    run = through_node(options.messages)
    print(f'{run.sent} messages, {run.lost} lost, {run.residuals} residuals, memory '
          f'{run.growth:+.1f} MB; processor time per message of each tenth [ms]: '
          f'{run.processor.round(3)}')


if __name__ == '__main__':
    main()

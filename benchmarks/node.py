"""
Measure the node against a bare relay with the same subscription and publishers.

Everything is on: all five topics of each arm are subscribed to. Alternating, in one run: latency
from publishing a joint state to receiving the residual that is made of it, processor time a
message, and residuals lost. Run: python benchmarks/node.py [--seconds 10] [--rounds 3]
"""

import argparse
import os
from pathlib import Path
from statistics import median
import subprocess
import sys
import time

from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import SIDES
from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.messages import joint_state, stamp_ns
from baxter_dynamics_ros.simulation.robot import JOINT_STATE_NAMES
from geometry_msgs.msg import WrenchStamped
import numpy as np
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from usage import processor_time

SETTLE = 1.0  # [s] streamed before anything is counted
KINDS = {
    'relay': [str(Path(__file__).with_name('relay.py'))],
    'node': ['-m', 'baxter_dynamics_ros.nodes.torque_predictor'],
    'both': ['-m', 'baxter_dynamics_ros.nodes.torque_predictor', '--ros-args', '-p', 'arm:=both'],
    'newton': ['-m', 'baxter_dynamics_ros.nodes.torque_predictor', '--ros-args', '-p',
               'method:=newton_euler'],
}


KINDS_OF_TOPICS = {topics.PREDICTED_EFFORT: JointState, topics.EFFORT_RESIDUAL: JointState,
                   topics.EXTERNAL_EFFORT: JointState, topics.EXTERNAL_WRENCH: WrenchStamped,
                   topics.CONTACT: Bool}


class Driver(Node):
    """Publishes joint states at a rate, and notes when each comes back as a residual."""

    def __init__(self, sides: tuple):
        super().__init__('driver')
        self.publisher = self.create_publisher(
            JointState, topics.JOINT_STATES, topics.PUBLISHER_QOS)
        self.answers = []
        # Never spun: what the middleware receives for it is dropped there, at no cost to Python.
        self.listener = Node('listener')
        for side in sides:
            for name, kind in KINDS_OF_TOPICS.items():
                topic = topics.below_node(name, side).replace('~', '/torque_predictor')
                if name == topics.EFFORT_RESIDUAL and side == sides[0]:
                    self.residual = topic
                    self.create_subscription(kind, topic, self._on_answer, 1000)
                else:
                    self.listener.create_subscription(kind, topic, _ignore, 1)

    def _on_answer(self, message):
        self.answers.append((stamp_ns(message.header), time.perf_counter()))

    def stream(self, rate: float, seconds: float, settled) -> list:
        """
        Publish for a while; return (stamp [ns], time sent [s]) of what was sent once settled.

        ``settled`` is called at that moment.
        """
        sent = []
        begin = time.perf_counter()
        epoch = time.time_ns()
        k = 0
        while k < rate * (SETTLE + seconds):
            now = time.perf_counter() - begin
            if now < k / rate:
                rclpy.spin_once(self, timeout_sec=min(k / rate - now, 0.0005))
                continue
            t = k / rate
            if k == round(rate * SETTLE):
                sent.clear()
                settled()
            q = 0.3 + 0.2 * np.sin(t + np.arange(17.0))
            stamp = epoch + round(t * 1e9)
            qd = 0.2 * np.cos(t + np.arange(17.0))
            message = joint_state(JOINT_STATE_NAMES, stamp, q, qd, q)
            sent.append((stamp, time.perf_counter()))
            self.publisher.publish(message)
            k += 1
        until = time.perf_counter() + 0.5
        while time.perf_counter() < until:
            rclpy.spin_once(self, timeout_sec=0.01)
        return sent


def _ignore(message):
    pass


def measure(kind: str, rate: float, seconds: float) -> dict:
    """Run one kind of process at one rate."""
    rclpy.init(args=[])
    driver = Driver(SIDES if kind == 'both' else ('',))
    process = subprocess.Popen([sys.executable, *KINDS[kind]], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        limit = time.monotonic() + 20.0
        while (driver.publisher.get_subscription_count() == 0
               or driver.count_publishers(driver.residual) == 0):
            rclpy.spin_once(driver, timeout_sec=0.05)
            if time.monotonic() > limit:
                raise SystemExit(f'{kind} did not start')
        before = []
        counted = dict(driver.stream(rate, seconds,
                                     lambda: before.append(processor_time(process.pid))))
        used = processor_time(process.pid) - before[0]
    finally:
        process.terminate()
        process.wait(10)
        rclpy.try_shutdown()
    behind = 0 if kind == 'relay' else round(PredictorSettings().predictor().estimator.delay * 1e9)
    latencies = [received - counted[stamp + behind] for stamp, received in driver.answers
                 if stamp + behind in counted]
    return {'median [ms]': median(latencies) * 1e3,
            'p99 [ms]': float(np.percentile(latencies, 99)) * 1e3,
            'CPU [ms]': 1e3 * used / len(latencies),  # a message that was answered
            'lost': len(counted) - len(latencies)}


def main():
    """Print one table."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--seconds', type=float, default=10.0)
    parser.add_argument('--rounds', type=int, default=3)
    options = parser.parse_args()
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ.setdefault('ROS_DOMAIN_ID', '93')
    columns = ('median [ms]', 'p99 [ms]', 'CPU [ms]', 'lost')
    print(f'{"rate":>8} {"process":8}' + ''.join(f'{column:>13}' for column in columns))
    for rate in (100.0, 1000.0):
        rounds = [{kind: measure(kind, rate, options.seconds) for kind in KINDS}
                  for _ in range(options.rounds)]
        for kind in KINDS:
            values = [median(each[kind][column] for each in rounds) for column in columns]
            print(f'{rate:5.0f} Hz {kind:8}' + ''.join(f'{value:13.2f}' for value in values))
        for kind in list(KINDS)[1:]:
            ratios = [median(each[kind][column] / each['relay'][column] for each in rounds)
                      for column in columns[:3]]
            print(f'{kind:>8} / relay ' + ''.join(f'{ratio:13.2f}' for ratio in ratios))


if __name__ == '__main__':
    main()

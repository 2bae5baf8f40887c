"""
Compare the node with a relay that has the same subscription and publishers.

All five topics have subscribers. Measures, in alternating runs, the latency from publishing a
joint state to receiving its residual, processor time per message, and lost residuals.
Run: python benchmarks/node.py [--seconds 10] [--rounds 3]
"""

import argparse
import os
from pathlib import Path
from statistics import median
import subprocess
import sys
import time

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.messages import joint_state, stamp_ns
from baxter_dynamics_ros.simulation.robot import JOINT_STATE_NAMES
import numpy as np
import rclpy
from rclpy.node import Node
from relay import OUTPUTS
from sensor_msgs.msg import JointState
from usage import processor_time

SETTLE = 1.0  # initial time without measurement [s]
NODE = ['-m', 'baxter_dynamics_ros.nodes.torque_predictor']
KINDS = {'relay': [str(Path(__file__).with_name('relay.py'))], 'node': NODE,
         'newton': [*NODE, '--ros-args', '-p', 'method:=newton_euler']}
COLUMNS = ('median [ms]', 'p99 [ms]', 'CPU [ms]', 'lost')


class Driver(Node):
    """Publishes joint states at a rate and records the arrival of each residual."""

    def __init__(self):
        super().__init__('driver')
        self.publisher = self.create_publisher(
            JointState, topics.JOINT_STATES, topics.PUBLISHER_QOS)
        self.received = {}  # stamp [ns] -> time [s]
        # Never spun: its messages are dropped by the middleware at no cost to Python.
        self.listener = Node('listener')
        for name, kind in OUTPUTS.items():
            topic = f'/torque_predictor/{name}'
            if name == topics.EFFORT_RESIDUAL:
                self.residual = topic
                self.create_subscription(kind, topic, self._on_residual, 1000)
            else:
                self.listener.create_subscription(kind, topic, lambda message: None, 1)

    def _on_residual(self, message):
        self.received[stamp_ns(message.header)] = time.perf_counter()

    def spin(self, until: float):
        """Process messages until a time [s]."""
        while (left := until - time.perf_counter()) > 0.0:
            rclpy.spin_once(self, timeout_sec=min(left, 0.0005))

    def stream(self, rate: float, seconds: float) -> dict:
        """Publish for a while; return stamp [ns] -> time sent [s]."""
        sent, epoch, begin = {}, time.time_ns(), time.perf_counter()
        for k in range(round(rate * seconds)):
            self.spin(begin + k / rate)
            phase = k / rate + np.arange(17.0)
            q, qd = 0.3 + 0.2 * np.sin(phase), 0.2 * np.cos(phase)
            stamp = epoch + round(k / rate * 1e9)
            message = joint_state(JOINT_STATE_NAMES, stamp, q, qd, q)
            sent[stamp] = time.perf_counter()
            self.publisher.publish(message)
        return sent


def measure(kind: str, rate: float, seconds: float) -> dict:
    """Run one kind of process at one rate."""
    rclpy.init(args=[])
    driver = Driver()
    process = subprocess.Popen([sys.executable, *KINDS[kind]], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        limit = time.monotonic() + 20.0
        while not (driver.publisher.get_subscription_count()
                   and driver.count_publishers(driver.residual)):
            rclpy.spin_once(driver, timeout_sec=0.05)
            if time.monotonic() > limit:
                raise SystemExit(f'{kind} did not start')
        used = processor_time(process.pid)
        sent = driver.stream(rate, SETTLE + seconds)
        driver.spin(time.perf_counter() + 0.5)
        used = processor_time(process.pid) - used
    finally:
        process.terminate()
        process.wait(10)
        rclpy.try_shutdown()
    behind = 0 if kind == 'relay' else round(Predictor(PredictorSettings()).estimator.delay * 1e9)
    counted = list(sent)[round(rate * SETTLE):]
    latencies = [driver.received[stamp - behind] - sent[stamp] for stamp in counted
                 if stamp - behind in driver.received]
    return dict(zip(COLUMNS, (
        median(latencies) * 1e3, float(np.percentile(latencies, 99)) * 1e3,
        1e3 * used / len(sent), len(counted) - len(latencies))))


def main():
    """Print one table."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--seconds', type=float, default=10.0)
    parser.add_argument('--rounds', type=int, default=3)
    options = parser.parse_args()
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ.setdefault('ROS_DOMAIN_ID', '93')
    print(f'{"rate":>8} {"process":8}' + ''.join(f'{column:>13}' for column in COLUMNS))
    for rate in (100.0, 1000.0):
        rounds = [{kind: measure(kind, rate, options.seconds) for kind in KINDS}
                  for _ in range(options.rounds)]
        for kind in KINDS:
            values = [median(each[kind][column] for each in rounds) for column in COLUMNS]
            print(f'{rate:5.0f} Hz {kind:8}' + ''.join(f'{value:13.2f}' for value in values))


if __name__ == '__main__':
    main()

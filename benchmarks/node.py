"""
Compare the node with a relay that has the same subscription and publishers but computes nothing.

Measures in alternating runs, from the first second of predictions on, the latency from a joint
state to its residual, processor time per message, and lost residuals. All topics but the payload
estimate have subscribers. Run: python benchmarks/node.py [--seconds 10] [--rounds 3]
"""

import argparse
import subprocess
import sys
import time

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.messages import joint_state, stamp_ns
from baxter_dynamics_ros.nodes.process import run
from baxter_dynamics_ros.simulation.robot import JOINT_STATE_NAMES
from geometry_msgs.msg import WrenchStamped
import numpy as np
from processes import costs, isolate, spin
import rclpy
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

SETTLE = 1.0  # initial time with predictions that is not measured [s]
PATIENCE = 20.0  # for the process, and for predictions [s]
KINDS = {'relay': [__file__, '--relay'],
         'node': ['-m', 'baxter_dynamics_ros.nodes.torque_predictor']}
COLUMNS = ('median [ms]', 'p99 [ms]', 'CPU [ms]', 'lost')
OUTPUTS = {topics.PREDICTED_EFFORT: JointState, topics.EFFORT_RESIDUAL: JointState,
           topics.RESIDUAL_DEVIATION: JointState, topics.EXTERNAL_EFFORT: JointState,
           topics.EXTERNAL_WRENCH: WrenchStamped, topics.CONTACT: Bool}


class Relay(Node):
    """Publishes each joint state of 17 joints four times, cut to seven; a wrench; and a flag."""

    def __init__(self):
        super().__init__('torque_predictor')
        self._outputs = [(kind, self.create_publisher(kind, f'~/{name}', topics.PUBLISHER_QOS))
                         for name, kind in OUTPUTS.items()]
        self.create_subscription(
            JointState, topics.JOINT_STATES, self._on_joint_state, topics.SUBSCRIPTION_QOS,
            qos_overriding_options=QoSOverridingOptions.with_default_policies())

    def _on_joint_state(self, message):
        for field in ('name', 'position', 'velocity', 'effort'):
            setattr(message, field, getattr(message, field)[9:16])
        for kind, publisher in self._outputs:
            publisher.publish(message if kind is JointState else kind())


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

    def stream(self, rate: float, seconds: float, pid: int) -> tuple:
        """Publish; return stamp [ns] -> time sent [s] and processor time of what is measured."""
        sent, used, epoch, begin, k = {}, None, time.time_ns(), time.perf_counter(), 0
        while len(sent) < rate * seconds:
            while (left := begin + k / rate - time.perf_counter()) > 0.0:
                rclpy.spin_once(self, timeout_sec=min(left, 0.0005))
            if used is None and self.received:
                if time.perf_counter() > min(self.received.values()) + SETTLE:
                    used, _ = costs(pid)
            elif k > rate * PATIENCE and not self.received:
                raise SystemExit('no predictions')
            phase = k / rate + np.arange(17.0)
            q, qd = 0.3 + 0.2 * np.sin(phase), 0.2 * np.cos(phase)
            stamp = epoch + round(k / rate * 1e9)
            message = joint_state(JOINT_STATE_NAMES, stamp, q, qd, q)
            if used is not None:
                sent[stamp] = time.perf_counter()
            self.publisher.publish(message)
            k += 1
        spin(self, 0.5)
        return sent, costs(pid)[0] - used


def measure(kind: str, rate: float, seconds: float) -> tuple:
    """Run one kind of process at one rate; return the values of COLUMNS."""
    rclpy.init(args=[])
    driver = Driver()
    process = subprocess.Popen([sys.executable, *KINDS[kind]], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        if not spin(driver, PATIENCE, lambda: driver.publisher.get_subscription_count()
                    and driver.count_publishers(driver.residual)):
            raise SystemExit(f'{kind} did not start')
        sent, used = driver.stream(rate, seconds, process.pid)
    finally:
        process.terminate()
        process.wait(10)
        rclpy.try_shutdown()
    behind = 0 if kind == 'relay' else round(Predictor(PredictorSettings()).estimator.delay * 1e9)
    late = [1e3 * (driver.received[stamp - behind] - at) for stamp, at in sent.items()
            if stamp - behind in driver.received]
    return *np.percentile(late, [50, 99]), 1e3 * used / len(sent), len(sent) - len(late)


def main():
    """Print one table."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--seconds', type=float, default=10.0)
    parser.add_argument('--rounds', type=int, default=3)
    options = parser.parse_args()
    isolate(93)
    print(f'{"rate":>8} {"process":8}' + ''.join(f'{column:>13}' for column in COLUMNS))
    for rate in (100.0, 1000.0):
        rounds = [{kind: measure(kind, rate, options.seconds) for kind in KINDS}
                  for _ in range(options.rounds)]
        for kind in KINDS:
            values = np.median([each[kind] for each in rounds], axis=0)
            print(f'{rate:5.0f} Hz {kind:8}' + ''.join(f'{value:13.2f}' for value in values))


if __name__ == '__main__':
    sys.exit(run(Relay, 'relay', sys.argv[:1]) if '--relay' in sys.argv else main())

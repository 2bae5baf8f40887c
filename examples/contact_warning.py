"""
Warn when something touches the arm: which joints feel it and how much, and when it is over.

The residual is of motors that work against the push: it has the other sign, and comes later. A
joint is named where its external torque is more than a model that is not calibrated may be wrong
by. Where nothing is heard nothing is known, which is no "no": the watchdog warns.

Run: python examples/contact_warning.py
"""

from argparse import ArgumentParser
from contextlib import suppress
from time import monotonic

from baxter_dynamics_ros import JOINTS
import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

DOUBT = np.array([1.0, 2.0, 1.5, 1.1, 0.4, 0.6, 0.3])  # of a model that is not calibrated [N m]
SILENCE = 0.5  # [s]


class ContactWarning(Node):
    """Listens to torque_predictor, and prints."""

    def __init__(self) -> None:
        super().__init__('contact_warning')
        self.heard, self.began = monotonic(), 0.0  # [s]; began: 0 where there is no contact
        self.external, self.residual = np.zeros((2, 7))  # [N m]
        for topic, values in (('external_effort', self.external),
                              ('effort_residual', self.residual)):
            self.create_subscription(JointState, f'/torque_predictor/{topic}',
                                     lambda m, values=values: np.copyto(values, m.effort), 10)
        self.create_subscription(Bool, '/torque_predictor/contact', self.on_contact, 10)
        self.create_timer(SILENCE, self.watch)

    def on_contact(self, contact: Bool) -> None:
        """Say when contact begins and ends."""
        self.heard = monotonic()
        if contact.data and not self.began:
            self.began = self.heard
            self.watch()
        elif self.began and not contact.data:
            print(f'contact is over after {self.heard - self.began:.1f} s', flush=True)
            self.began = 0.0

    def watch(self) -> None:
        """Say which joints feel the push, or the one that feels it most; or that all is silent."""
        if monotonic() - self.heard > SILENCE:
            print(f'nothing heard for {SILENCE:g} s: contact is not known', flush=True)
            self.heard, self.began = np.inf, 0.0  # said once
        elif self.began:
            much = np.abs(self.external) / DOUBT
            print(f'contact for {monotonic() - self.began:.1f} s [N m]:', ', '.join(
                f'{JOINTS[i]} external {self.external[i]:+.1f} residual {self.residual[i]:+.1f}'
                for i in np.flatnonzero(much >= min(1.0, much.max()))), flush=True)


def main() -> None:
    """Listen until it is interrupted, or for a while."""
    parser = ArgumentParser()
    parser.add_argument('--duration', type=float, default=np.inf, help='[s]; endless by default')
    options = parser.parse_args()
    rclpy.init()
    node, end = ContactWarning(), monotonic() + options.duration
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        while monotonic() < end:
            rclpy.spin_once(node, timeout_sec=0.1)


if __name__ == '__main__':
    main()

"""
Warn when something touches the arm: which joints feel it and how much, and when it is over.

The residual is of motors that work against the push: it has the other sign, and comes later. A
joint is named where its external torque is more than a model that is not calibrated may be wrong
by. Where nothing is heard nothing is known, which is no "no": the watchdog warns.

Run: python examples/contact_warning.py
"""

from argparse import ArgumentParser
from contextlib import suppress
from math import inf
from time import monotonic

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

# Of a model that is not calibrated [N m].
DOUBT = {'s0': 1.0, 's1': 2.0, 'e0': 1.5, 'e1': 1.1, 'w0': 0.4, 'w1': 0.6, 'w2': 0.3}
SILENCE = 0.5  # [s]


class ContactWarning(Node):
    """Listens to torque_predictor, and prints."""

    def __init__(self) -> None:
        super().__init__('contact_warning')
        self.heard, self.began = monotonic(), 0.0  # [s]; began: 0 where there is no contact
        self.external, self.residual = {}, {}  # by joint [N m]
        for topic, values in (('external_effort', self.external),
                              ('effort_residual', self.residual)):
            self.create_subscription(
                JointState, f'/torque_predictor/{topic}', lambda message, values=values:
                values.update(zip((name[-2:] for name in message.name), message.effort)), 10)
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
            self.heard, self.began = inf, 0.0  # said once
        elif self.began:
            much = {joint: abs(self.external[joint]) / DOUBT[joint] for joint in self.external}
            print(f'contact for {monotonic() - self.began:.1f} s [N m]:', ', '.join(
                f'{joint} external {self.external[joint]:+.1f} '
                f'residual {self.residual.get(joint, 0.0):+.1f}'
                for joint in much if much[joint] >= min(1.0, *much.values())), flush=True)


def main() -> None:
    """Listen until it is interrupted, or for a while."""
    parser = ArgumentParser()
    parser.add_argument('--duration', type=float, default=inf, help='[s]; endless by default')
    options = parser.parse_args()
    rclpy.init()
    node, end = ContactWarning(), monotonic() + options.duration
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        while monotonic() < end:
            rclpy.spin_once(node, timeout_sec=0.1)


if __name__ == '__main__':
    main()

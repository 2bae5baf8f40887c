"""
Print a warning while something touches the arm: the joints, the torques, and the duration.

The residual shows the motors working against the push, with the opposite sign and a longer delay.
Joints are printed whose external torque exceeds the error of an uncalibrated model, or else the
joint that comes nearest to it. A watchdog warns if no messages arrive, because contact is then
unknown.

Run: python examples/contact_warning.py
"""

from argparse import ArgumentParser
from functools import partial
from math import inf, nan
import signal
from time import monotonic

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

# Error of an uncalibrated model [N m].
MODEL_ERROR = {'s0': 1.0, 's1': 2.0, 'e0': 1.5, 'e1': 1.1, 'w0': 0.4, 'w1': 0.6, 'w2': 0.3}
SILENCE = 0.5  # [s]


class ContactWarning(Node):
    """Prints contacts reported by torque_predictor."""

    def __init__(self) -> None:
        super().__init__('contact_warning')
        self.heard, self.began = monotonic(), 0.0  # [s]; began: 0 without contact
        self.external, self.residual = {}, {}  # by joint [N m]
        for topic, values in (('external_effort', self.external),
                              ('effort_residual', self.residual)):
            self.create_subscription(
                JointState, f'/torque_predictor/{topic}', partial(keep, values), 10)
        self.create_subscription(Bool, '/torque_predictor/contact', self.on_contact, 10)
        self.create_timer(SILENCE, self.watch)

    def on_contact(self, contact: Bool) -> None:
        """Print the beginning and the end of a contact."""
        self.heard = monotonic()
        if contact.data and not self.began:
            self.began = self.heard
            self.watch()
        elif self.began and not contact.data:
            print(f'contact is over after {self.heard - self.began:.1f} s', flush=True)
            self.began = 0.0

    def watch(self) -> None:
        """Print the joints in contact, or a warning if no messages arrive."""
        if monotonic() - self.heard > SILENCE:
            print(f'no messages for {SILENCE:g} s: contact is unknown', flush=True)
            self.heard, self.began = inf, 0.0  # warn once
        elif self.began:
            ratio = {joint: abs(torque) / MODEL_ERROR[joint]
                     for joint, torque in self.external.items()}
            joints = [joint for joint in ratio if ratio[joint] >= min(1.0, max(ratio.values()))]
            print(f'contact for {monotonic() - self.began:.1f} s [N m]:', ', '.join(
                f'{joint} external {self.external[joint]:+.1f} '
                f'residual {self.residual.get(joint, nan):+.1f}' for joint in joints), flush=True)


def keep(torques: dict, message: JointState) -> None:
    """Keep the newest torque of each joint, 's0' to 'w2' [N m]."""
    torques.update(zip((name[-2:] for name in message.name), message.effort))


def main() -> None:
    """Run until interrupted, or for the given duration."""
    parser = ArgumentParser()
    parser.add_argument('--duration', type=float, default=inf, help='seconds; default: unlimited')
    options = parser.parse_args()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)  # Ctrl-C ends the loop below
    interrupts = []
    signal.signal(signal.SIGINT, lambda number, frame: interrupts.append(number))
    node, end = ContactWarning(), monotonic() + options.duration
    while monotonic() < end and not interrupts:
        rclpy.spin_once(node, timeout_sec=0.1)


if __name__ == '__main__':
    main()

"""
Identify mass and centre of mass of a payload from residuals at rest in three postures.

The residual is the gravity torque of the payload, linear in m and m c. Friction averages out when
each posture is approached from both sides (--rests 6).

Run: python examples/payload_from_three_poses.py
"""

from argparse import ArgumentParser
from contextlib import suppress
from time import monotonic

from baxter_dynamics_ros import BaxterArm, joint_names, Payload
import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import JointState

NAMES = joint_names('right')
MODEL_ERROR = np.array([1.0, 2.0, 1.5, 1.1, 0.4, 0.6, 0.3])  # without calibration [N m]
STILL = 0.01 * np.array([1, 1, 1, 1, 10, 10, 10])  # motion in 0.5 s; the wrist may swing [rad]


def fit(q: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mass and centre of mass (4,) [kg, m], and their sd, from n rests (n, 7)."""
    mass, *at = (BaxterArm(payload=Payload(1.0, place)).gravity(q) - BaxterArm().gravity(q)
                 for place in np.vstack([np.zeros(3), np.eye(3)]))  # 1 kg at 0, at 1 m [N m]
    columns = np.stack([mass, *(each - mass for each in at)], axis=-1)  # of m, m c
    a, b = (columns / MODEL_ERROR[:, None]).reshape(-1, 4), (residual / MODEL_ERROR).ravel()
    load = np.linalg.lstsq(a, b, rcond=None)[0]
    variance = np.sum((b - a @ load) ** 2) / (len(b) - 4) * np.linalg.inv(a.T @ a)
    slope = np.diag([1.0, *3 * [1.0 / load[0]]])  # derivative of (m, c) by (m, m c)
    slope[1:, 0] = -load[1:] / load[0] ** 2
    return np.diag(slope) * load, np.sqrt(np.diag(slope @ variance @ slope.T))


class Rests(Node):
    """Collects the mean position and residual (2, 7) [rad, N m] of each rest."""

    def __init__(self) -> None:
        super().__init__('payload_from_three_poses')
        self.last, self.rest, self.rests = [], [], []
        self.create_subscription(JointState, '/torque_predictor/effort_residual', self.gather, 100)

    def gather(self, message: JointState) -> None:
        """Collect samples while the arm rests; a rest ends when the arm moves."""
        order = [message.name.index(name) for name in NAMES]  # last: 0.5 s
        self.last = [*self.last[-49:], np.array([message.position, message.effort])[:, order]]
        if len(self.last) == 50 and (np.ptp(self.last, axis=0)[0] < STILL).all():
            self.rest.append(self.last[-1])
        elif len(self.rest) > 10:
            mean, self.rest = np.mean(self.rest, axis=0), []
            if self.rests and np.abs(mean - self.rests[-1])[0].max() < 0.2:  # the same posture
                self.rests.pop()
            self.rests.append(mean)


def main() -> None:
    """Wait for the rests, then print the payload and the commands that set it."""
    parser = ArgumentParser()
    parser.add_argument('--rests', type=int, default=3, help='rests to use; 3 by default')
    options = parser.parse_args()
    rclpy.init()
    node, end = Rests(), monotonic() + 60.0  # [s]
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        while monotonic() < end and len(node.rests) < options.rests:
            rclpy.spin_once(node, timeout_sec=0.1)
    if len(node.rests) < 3:
        parser.exit(1, 'fewer than three rests: move the arm through different postures\n')
    (mass, *center), sd = fit(*np.swapaxes(node.rests, 0, 1))
    print(f'mass {mass:.3f} +- {sd[0]:.3f} kg, centre of mass',
          *(f'{place:.3f} +- {each:.3f}' for place, each in zip(center, sd[1:])), 'm')
    for line in f'mass {mass:.3f}', f'center_of_mass "{(np.round(center, 3) + 0.0).tolist()}"':
        print('ros2 param set /torque_predictor payload.' + line)


if __name__ == '__main__':
    main()

"""
Hold an arm by gravity compensation alone, with torques from the service ~/gravity_torques.

A little damping is subtracted, because gravity compensation alone does not stop a pushed arm; more
damping would make the arm vibrate, as the measured velocity is noisy and delayed.

A real Baxter accepts torques on /robot/limb/right/joint_command (baxter_core_msgs/JointCommand,
mode 3, through a bridge). It adds its own gravity compensation unless std_msgs/Empty arrives on
/robot/limb/right/suppress_gravity_compensation at more than 5 Hz. Support the arm at the start.

Run: python examples/gravity_compensation.py
"""

from argparse import ArgumentParser
from contextlib import suppress
from time import monotonic

from baxter_dynamics_interfaces.srv import GravityTorques
from baxter_dynamics_ros import joint_names, JOINTS
import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import JointState

NAMES = joint_names('right')
DAMPING = np.array([2.0, 2.0, 0.5, 1.0, 0.02, 0.05, 0.005])  # [N m s/rad]; stops in about 1 s
PATIENCE = 0.15  # timeout of a request [s]; after 0.2 s without torques the robot holds itself


class GravityCompensation(Node):
    """Commands gravity torques to the fake Baxter's right arm, or zero torques if limp."""

    def __init__(self, duration: float, limp: bool) -> None:
        super().__init__('gravity_compensation')
        self.duration, self.limp, self.asked, self.places = duration, limp, 0.0, []
        self.end = monotonic() + 10.0  # time limit of the first response [s]
        self.client = self.create_client(GravityTorques, '/torque_predictor/gravity_torques')
        self.publisher = self.create_publisher(JointState, '/fake_baxter/joint_torque_command', 1)
        self.create_subscription(JointState, '/robot/joint_states', self.on_state, 10)

    def on_state(self, state: JointState) -> None:
        """Request the gravity torques, unless a request is pending."""
        if set(NAMES) <= set(state.name) and monotonic() - self.asked > PATIENCE:
            self.asked, order = monotonic(), [state.name.index(name) for name in NAMES]
            motion = np.array([state.position, state.velocity])[:, order]  # [rad], [rad/s]
            self.client.call_async(GravityTorques.Request(state=state)).add_done_callback(
                lambda future: self.on_answer(future.result(), motion))

    def on_answer(self, answer: GravityTorques.Response, motion: np.ndarray) -> None:
        """Command the torques of the response, minus damping."""
        self.asked = 0.0
        if answer.success:
            self.end = self.end if self.places else monotonic() + self.duration
            torque = np.zeros(7) if self.limp else answer.actuator_effort - DAMPING * motion[1]
            self.publisher.publish(JointState(name=NAMES, effort=torque.tolist()))
            self.places.append(motion[0])


def main() -> None:
    """Hold the arm for a while and print how far it drifted."""
    parser = ArgumentParser()
    parser.add_argument('--duration', type=float, default=3.0, help='duration [s], 3 by default')
    parser.add_argument('--limp', action='store_true', help='command zero torques instead')
    options = parser.parse_args()
    rclpy.init()
    node = GravityCompensation(options.duration, options.limp)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        while monotonic() < node.end:
            rclpy.spin_once(node, timeout_sec=0.1)
    if not node.places:
        parser.exit(1, 'no torques: start fake_baxter and torque_predictor\n')
    moved = zip(JOINTS, 1e3 * (node.places[-1] - node.places[0]))
    print(f'{len(node.places)} torques in {options.duration:g} s; the joints moved by [mrad]',
          *(f'{joint} {angle:.1f}' for joint, angle in moved), sep='\n')


if __name__ == '__main__':
    main()

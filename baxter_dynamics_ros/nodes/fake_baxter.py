"""Node fake_baxter: simulated Baxter that publishes joint states like the real robot."""

from dataclasses import replace
from functools import partial
import sys
from typing import Any

import numpy as np
from sensor_msgs.msg import JointState

from . import topics
from .messages import from_field, joint_state
from .process import run
from .ros_parameters import ParameterNode
from ..estimation.events import Event
from ..estimation.settings import SETTINGS
from ..estimation.stream import JointSelector
from ..model import ArgumentError, Array, BaxterDynamicsError, N_JOINTS, Payload, Setting, SIDES

_LOG_PERIOD = 1.0  # minimum time between log lines about rejected commands [s]
_MAX_BEHIND = 0.5  # delay beyond which the simulation skips time instead of catching up [s]
_PHYSICS = ('payload.mass', 'payload.center_of_mass', 'gravity')  # shared with the predictor
# External loads on the moving arm; can be changed while the node runs.
_LOADS = (
    Setting('force', (0.0,) * 3, 'External force on the moving hand, axes of the base.', 'N',
            -200.0, 200.0),
    Setting('torque', (0.0,) * N_JOINTS, 'External torque on the moving joints, s0 ... w2.', 'N m',
            -50.0, 50.0))


def _settings(trajectories: tuple[str, ...]) -> tuple[Setting, ...]:
    fixed = (
        Setting('arm', 'right', 'Arm that moves (right or left).', choices=SIDES),
        Setting('trajectory', 'circle', "circle, switch, lift: the paper's trajectories "
                '3(a) to 3(c). exciting: 60 s of motion for calibration. hold: rest at the start '
                'of the circle. poses: visit three postures in turn.', choices=trajectories),
        Setting('spring', True, 'Simulate the springs at s1.'),
        Setting('friction', True, 'Simulate joint friction.'),
        Setting('noise', True, 'Simulate sensor noise and quantisation.'),
        Setting('seed', 0, 'Seed of the sensor noise.', lower=0, upper=2 ** 31 - 1),
        Setting('description', '', 'Path of a Baxter URDF. Empty: the URDF of hpp-baxter.'),
        Setting('rate', 100.0, 'Rate of the joint states; the simulation has a time step of 1 ms.',
                'Hz', 1.0, 1000.0),
        *(setting for setting in SETTINGS if setting.name in _PHYSICS))
    return (*(replace(setting, read_only=True) for setting in fixed), *_LOADS)


class FakeBaxterNode(ParameterNode):
    """Publishes the joint states of a simulated Baxter and accepts torque commands."""

    def __init__(self) -> None:
        super().__init__('fake_baxter')
        try:
            from ..simulation import robot
            from ..simulation.plant import default_truth
        except ImportError as error:
            raise BaxterDynamicsError(
                f'needs MuJoCo ({error}): pip install mujoco hpp-baxter') from None
        given = self.declare_settings(_settings(robot.TRAJECTORIES))
        self._baxter = robot.FakeBaxter(
            given['arm'], given['trajectory'], given['description'] or None, given['noise'],
            given['seed'], default_truth(given['spring'], given['friction']),
            payload=Payload(given['payload.mass'], given['payload.center_of_mass']),
            gravity=given['gravity'])
        self.apply(given)
        self.check_given_names()

        self._selector = JointSelector(given['arm'])
        self._rejected = 0  # number of torque commands
        self._was_commanded = False
        self.create_subscription(
            JointState, f'~/{topics.JOINT_TORQUE_COMMAND}', self._on_command,
            topics.SUBSCRIPTION_QOS)
        self._publisher = self.create_publisher(
            JointState, topics.JOINT_STATES, topics.PUBLISHER_QOS)
        self._states = robot.JointStates(self._baxter, given['rate'], given['seed'],
                                         self.get_clock().now().nanoseconds)
        self.create_timer(min(1.0 / given['rate'], 1.0 / robot.GRIPPER_RATE), self._on_timer)
        self.get_logger().info(
            f'simulating a Baxter: {given["arm"]} arm, trajectory {given["trajectory"]}, '
            f'{given["rate"]:g} joint states per second on {self._publisher.topic_name}; '
            f'{self.changed_settings()}')

    def apply(self, built: dict[str, Any]) -> None:
        """Set the external loads."""
        for setting in _LOADS:
            load = np.array(built[setting.name])
            if not np.array_equal(load, getattr(self._baxter.plant, setting.name)):
                setattr(self._baxter.plant, setting.name, load)
                self.get_logger().info(f'{setting.name}: {load.tolist()} {setting.unit}')

    def _on_timer(self) -> None:
        now = self.get_clock().now().nanoseconds
        behind = (now - self._states.due_ns) * 1e-9
        if abs(behind) > _MAX_BEHIND:
            self.get_logger().warning(
                f'{abs(behind):.2f} s {"behind" if behind > 0.0 else "ahead of"} the clock: the '
                'process was too slow or suspended, or the clock was set; continuing from now')
            self._states.start_ns += int(behind * 1e9)
        while self._states.due_ns <= now:  # stamps are never in the future
            stamp, names, *fields = self._states.take()
            self._publisher.publish(joint_state(names, stamp, *fields))
        if self._baxter.is_commanded is not self._was_commanded:
            self._was_commanded = self._baxter.is_commanded
            self.get_logger().info(
                'receiving torque commands: applying them without gravity compensation'
                if self._was_commanded else 'torque commands ended: holding the present position')

    def _on_command(self, message: JointState) -> None:
        """Apply a torque command, or reject it entirely."""
        try:
            self._baxter.command(self._torque(message))
        except ArgumentError as error:
            self._rejected += 1
            self.get_logger().warning(
                f'{self._rejected} torque commands rejected so far, last reason: {error}',
                throttle_duration_sec=_LOG_PERIOD)

    def _torque(self, message: JointState) -> Array:
        """Return the effort (7,) [N m] of a command, matched to the joints by name."""
        layout = self._selector.layout(message.name)
        if isinstance(layout, Event):
            raise ArgumentError('name', f'expected {" ".join(self._selector.names)}, each once '
                                f'({layout.value})')
        if len(message.effort) != len(message.name):
            raise ArgumentError('effort', f'expected {len(message.name)} values, one per name, '
                                f'got {len(message.effort)}')
        return from_field(message.effort)[layout]


main = partial(run, FakeBaxterNode, 'fake_baxter')

if __name__ == '__main__':
    sys.exit(main())

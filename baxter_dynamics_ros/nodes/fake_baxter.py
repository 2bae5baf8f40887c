"""The node that plays a Baxter: publishes joint states as the real robot does."""

from collections.abc import Iterable, Sequence
import sys
from typing import Any

import numpy as np
from rcl_interfaces.msg import (FloatingPointRange, IntegerRange, ParameterDescriptor,
                                SetParametersResult)
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from . import topics
from .messages import from_field, joint_state
from .process import run
from .ros_parameters import refuse_misspelt
from ..estimation.events import Event
from ..estimation.joint_selection import JointSelector
from ..estimation.settings import SETTINGS
from ..model.arrays import Array
from ..model.exceptions import ArgumentError, BaxterDynamicsError
from ..model.joints import N_JOINTS, SIDES
from ..model.parameters import Payload
from ..model.validation import finite

_LOG_PERIOD = 1.0  # [s] between two lines about refused commands
_MAX_BEHIND = 0.5  # [s]; further behind, the robot skips time instead of catching up
# What may push the moving arm while it runs: length, greatest size, unit, and what it is.
_PUSHES = {'force': (3, 200.0, 'N', "Force on the moving hand, axes of the robot's base"),
           'torque': (N_JOINTS, 50.0, 'N m', 'External torque on the joints, s0 ... w2')}
_PHYSICS = ('payload.mass', 'payload.center_of_mass', 'gravity')  # named as the predictor's


class FakeBaxterNode(Node):
    """Play a Baxter: publish joint states as the real robot does, and obey torque commands."""

    def __init__(self) -> None:
        super().__init__('fake_baxter')
        try:
            from ..simulation import robot
            from ..simulation.recorder import JointStates
        except ImportError as error:
            raise BaxterDynamicsError(
                f'needs MuJoCo ({error}): pip install mujoco hpp-baxter') from None
        self._fixed('arm', 'right', 'The arm that moves: right or left.', SIDES)
        self._fixed('trajectory', 'circle', "circle, switch, lift: the paper's 3(a) to (c). "
                    'exciting: 60 s for a calibration. hold: stay where the circle begins. '
                    'poses: rest in three postures by turns.', robot.TRAJECTORIES)
        self._fixed('spring', True, 'Whether the robot has springs at s1.')
        self._fixed('friction', True, 'Whether the joints have friction.')
        self._fixed('noise', True, 'Whether the sensors have noise and quanta.')
        self.declare_parameter('seed', 0, ParameterDescriptor(
            description='Of the noise.', read_only=True,
            integer_range=[IntegerRange(from_value=0, to_value=2 ** 31 - 1, step=1)]))
        self._fixed('description', '', "Path of a Baxter's URDF; empty: that of hpp-baxter.")
        rate = self.declare_parameter('rate', 100.0, ParameterDescriptor(
            description='Rate of the joint states [Hz]; each is of the nearest millisecond.',
            read_only=True,
            floating_point_range=[FloatingPointRange(from_value=1.0, to_value=1000.0)])).value
        for name, (length, most, unit, description) in _PUSHES.items():
            self.declare_parameter(name, [0.0] * length, ParameterDescriptor(
                description=f'{description} [{unit}].',
                additional_constraints=f'{length} numbers from {-most:g} to {most:g}'))
        load = {name: self._physics(name) for name in _PHYSICS}
        value = {name: self.get_parameter(name).value for name in (
            'arm', 'trajectory', 'spring', 'friction', 'noise', 'seed', 'description',
            *_PUSHES)}
        self._baxter = robot.FakeBaxter(
            value['arm'], value['trajectory'], value['description'] or None, value['spring'],
            value['friction'], value['noise'], value['seed'],
            payload=Payload(load['payload.mass'], load['payload.center_of_mass']),
            gravity=load['gravity'])
        for name in _PUSHES:
            setattr(self._baxter, name, _push(name, value[name]))
        refuse_misspelt(self)
        self.add_on_set_parameters_callback(_verdict)
        self.add_post_set_parameters_callback(self._on_parameters_set)

        self._selector = JointSelector(value['arm'])
        self._refused = 0  # torque commands
        self._was_commanded = False
        self.create_subscription(
            JointState, topics.below_node(topics.JOINT_TORQUE_COMMAND), self._on_command,
            topics.SUBSCRIPTION_QOS)
        self._publisher = self.create_publisher(
            JointState, topics.JOINT_STATES, topics.PUBLISHER_QOS)
        self._states = JointStates(self._baxter, rate, value['seed'],
                                   self.get_clock().now().nanoseconds)
        self.create_timer(min(1.0 / rate, 1.0 / robot.GRIPPER_RATE), self._on_timer)
        self.get_logger().info(
            f'a Baxter\'s {value["arm"]} arm runs the trajectory {value["trajectory"]}, '
            f'{rate:g} joint states a second on {self._publisher.topic_name}')

    def _on_timer(self) -> None:
        now = self.get_clock().now().nanoseconds
        behind = (now - self._states.due_ns) * 1e-9
        if behind > _MAX_BEHIND:  # the robot's time stands still meanwhile
            self.get_logger().warning(f'{behind:.2f} s behind: this machine is too slow or was '
                                      "stopped; the robot's clock skips")
            self._states.start_ns += int(behind * 1e9)
        while self._states.due_ns <= now:  # a stamp lies in the past
            stamp, names, *fields = next(self._states)
            self._publisher.publish(joint_state(names, stamp, *fields))
        self._log_who_is_in_command()

    def _on_command(self, message: JointState) -> None:
        """Obey a torque command; refuse one that is not wholly good."""
        try:
            self._baxter.command(self._torque(message))
        except ArgumentError as error:
            self._refused += 1
            self.get_logger().warning(
                f'{self._refused} torque commands refused so far, the last one for its {error}',
                throttle_duration_sec=_LOG_PERIOD)

    def _torque(self, message: JointState) -> Array:
        """Return a command's effort (7,) [N m], matched to the arm's joints by name."""
        layout = self._selector.layout(message.name)
        if isinstance(layout, Event):
            raise ArgumentError('name', f'expected each of {" ".join(self._selector.names)} once '
                                f'({layout.value})')
        if len(message.effort) != len(message.name):
            raise ArgumentError('effort', f'expected {len(message.name)} values, as many as name, '
                                f'got {len(message.effort)}')
        return from_field(message.effort)[layout]

    def _log_who_is_in_command(self) -> None:
        if self._baxter.is_commanded is not self._was_commanded:
            self._was_commanded = self._baxter.is_commanded
            self.get_logger().info(
                'torque commands: the motors supply them and nothing else' if self._was_commanded
                else 'no torque command is obeyed now: the arm is held where it is')

    def _on_parameters_set(self, changes: list[Parameter]) -> None:
        for parameter in changes:
            if parameter.name in _PUSHES:
                push = _push(parameter.name, parameter.value)
                setattr(self._baxter, parameter.name, push)
                self.get_logger().info(
                    f'{parameter.name}: {push.tolist()} {_PUSHES[parameter.name][2]}')

    def _physics(self, name: str) -> Any:
        """Declare what the predictor has a setting for too, and return its value."""
        setting = next(setting for setting in SETTINGS if setting.name == name)
        default = setting.default
        value = self.declare_parameter(
            name, list(default) if isinstance(default, tuple) else default,
            ParameterDescriptor(description=f'{setting.description} [{setting.unit}]',
                                read_only=True)).value
        return setting.check(list(value) if isinstance(default, tuple) else value)

    def _fixed(self, name: str, default: Any, description: str,
               choices: Sequence[str] = ()) -> None:
        """Declare a parameter that is fixed when the node starts."""
        value = self.declare_parameter(
            name, default, ParameterDescriptor(description=description, read_only=True)).value
        if choices and value not in choices:
            raise ArgumentError(name, f'expected one of {", ".join(choices)}, got {value!r}')


def _push(name: str, value: Iterable[float]) -> Array:
    length, most, unit, _ = _PUSHES[name]
    push = finite(name, list(value), (length,))
    if np.abs(push).max() > most:
        raise ArgumentError(name, f'expected at most {most:g} {unit}, got {push}')
    return push


def _verdict(changes: list[Parameter]) -> SetParametersResult:
    for parameter in changes:
        if parameter.name in _PUSHES:
            try:
                _push(parameter.name, parameter.value)
            except ArgumentError as error:
                return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)


def main(args: list[str] | None = None) -> int:
    """Run the fake Baxter until it is interrupted or terminated."""
    return run(FakeBaxterNode, 'fake_baxter', args)


if __name__ == '__main__':
    sys.exit(main())

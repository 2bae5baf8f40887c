"""The node: predicts arms' efforts from joint states, and tells what differs and what pushes."""

import sys
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from . import topics
from .arm_publisher import Arm
from .diagnostics import report
from .messages import from_field, stamp_ns
from .process import run
from .ros_parameters import no_such, Parameters, refuse_misspelt
from ..model.exceptions import ArgumentError

_DIAGNOSTICS_PERIOD = 1.0  # [s]
_AT_ONCE = 30  # joint states; then others have their turn


class TorquePredictor(Node):
    """Predict the effort of Baxter's arms from joint states; publish what differs, what pushes."""

    def __init__(self) -> None:
        super().__init__('torque_predictor')
        self._given = Parameters.declare(self)
        settings = self._given.settings
        only = len(settings) == 1
        self._arms = {side: Arm(self, its, '' if only else side) for side, its in settings.items()}
        self._last_report = time.monotonic()
        # Status name -> (level, message), to log changes.
        self._reported: dict[str, tuple[bytes, str]] = {}
        self._diagnostics = self.create_publisher(
            DiagnosticArray, topics.DIAGNOSTICS, topics.PUBLISHER_QOS)
        self.create_service(Trigger, topics.RESET, self._on_reset)
        self._offer_services()
        self._subscription = self.create_subscription(
            JointState, topics.JOINT_STATES, self._on_joint_state, topics.SUBSCRIPTION_QOS,
            qos_overriding_options=QoSOverridingOptions.with_default_policies())
        # Diagnostics go on when simulated time stands still.
        self.create_timer(_DIAGNOSTICS_PERIOD, self._on_diagnostics,
                          clock=Clock(clock_type=ClockType.STEADY_TIME))
        refuse_misspelt(self)
        self.add_on_set_parameters_callback(
            lambda changes: self._given.verdict(changes))
        self.add_post_set_parameters_callback(self._on_parameters_set)
        for arm in self._arms.values():
            names = arm.predictor.stream.intake.names
            self.get_logger().info(
                f'predicting {names[0]} ... {names[-1]} from {self._subscription.topic_name}, '
                f'{arm.predictor.estimator.delay * 1000:.0f} ms behind the newest joint state')

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set parameters as rclpy does, but say which one is refused."""
        try:
            for parameter in parameter_list:
                if not self.has_parameter(parameter.name):
                    raise ArgumentError(parameter.name, no_such(self, parameter.name))
            self._given.refuse_other_types(parameter_list)
        except ArgumentError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return super().set_parameters_atomically(parameter_list)

    def _on_joint_state(self, message: JointState) -> None:
        """Take a joint state, and those that wait behind it: rclpy would take one a round."""
        self._take(message)
        for _ in range(_AT_ONCE):
            waiting = self._subscription.handle.take_message(JointState, False)
            if waiting is None:
                break
            self._take(waiting[0])

    def _take(self, message: JointState) -> None:
        stamp = stamp_ns(message.header)
        stamped = stamp != 0
        if not stamped:
            stamp = self.get_clock().now().nanoseconds
        fields = (message.name, from_field(message.position), from_field(message.velocity),
                  from_field(message.effort))
        for arm in self._arms.values():
            arm.take(stamp, stamped, *fields)

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        predictors = [arm.predictor for arm in self._arms.values()]
        retimed = any(predictor.stream.clock.retimed for predictor in predictors)
        for arm in self._arms.values():
            arm.reset()
        response.success = True
        response.message = ('filter state and what free motion is like are forgotten: predictions '
                            f'return after {predictors[0].estimator.settling_time:.2f} s'
                            + ', once the period of the stamps is found again' * retimed)
        return response

    def _on_parameters_set(self, changes: list[Parameter]) -> None:
        self._given = self._given.proposed(changes)
        for side, settings in self._given.settings.items():
            self._arms[side].configure(settings)

    def _on_diagnostics(self) -> None:
        now = time.monotonic()
        period = now - self._last_report
        self._last_report = now
        name, topic = self.get_fully_qualified_name().lstrip('/'), self._subscription.topic_name
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        for arm in self._arms.values():
            arm.statistics.close(arm.predictor.counts, period)
            message.status += report('/'.join(filter(None, (name, arm.side))), topic,
                                     self.count_publishers(topic), arm)
            arm.statistics.begin()
        self._diagnostics.publish(message)
        for status in message.status:
            said = status.level, status.message
            if self._reported.get(status.name) != said:
                self._log(status)
            self._reported[status.name] = said

    def _log(self, status: DiagnosticStatus) -> None:
        """Say a status that has changed in the log, too."""
        here = self.get_fully_qualified_name().strip('/')  # which the log says by itself
        text = f'{status.name.removeprefix(here).lstrip("/: ")}: {status.message}'
        if status.level != DiagnosticStatus.OK:
            self.get_logger().warning(text)
        elif self._reported.get(status.name, (DiagnosticStatus.OK,))[0] != DiagnosticStatus.OK:
            self.get_logger().info(text)

    def _offer_services(self) -> None:
        try:
            from baxter_dynamics_interfaces.srv import GravityTorques, InverseDynamics
        except ImportError:
            self.get_logger().warning(
                'services gravity_torques and inverse_dynamics are off: their types are in the '
                'package baxter_dynamics_interfaces, which is not installed. It lies beside this '
                'one: build it with colcon, or `pip install ./baxter_dynamics_interfaces`')
            return
        for arm in self._arms.values():
            arm.offer_services(GravityTorques, InverseDynamics)


def main(args: list[str] | None = None) -> int:
    """Run the node until it is interrupted or terminated."""
    return run(TorquePredictor, 'torque_predictor', args)


if __name__ == '__main__':
    sys.exit(main())

"""Node torque_predictor: predicted effort, residual and external torque of one arm."""

import sys
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from . import topics
from .arm_publisher import Arm
from .diagnostics import report
from .message_loss import MessageLoss
from .messages import from_field, stamp_ns
from .process import run
from .rclpy_internals import take_waiting
from .ros_parameters import ParameterNode
from ..estimation.settings import PredictorSettings, SETTINGS

_DIAGNOSTICS_PERIOD = 1.0  # [s]
_BATCH = 30  # maximum number of joint states per callback, so that other callbacks run


class TorquePredictor(ParameterNode):
    """Predicts one arm's effort and estimates the external torque."""

    def __init__(self) -> None:
        super().__init__('torque_predictor')
        self._arm = Arm(self, self.declare_settings(SETTINGS))
        self._loss = MessageLoss()
        self._last_report = time.monotonic()
        # Name of a status -> (level, message) logged last.
        self._logged: dict[str, tuple[bytes, str]] = {}
        self._diagnostics = self.create_publisher(
            DiagnosticArray, topics.DIAGNOSTICS, topics.PUBLISHER_QOS)
        self.create_service(Trigger, topics.RESET, self._on_reset)
        self._offer_services()
        self._subscription = self.create_subscription(
            JointState, topics.JOINT_STATES, self._on_joint_state, topics.SUBSCRIPTION_QOS,
            event_callbacks=SubscriptionEventCallbacks(
                matched=lambda info: self._loss.matched(info.total_count_change)),
            qos_overriding_options=QoSOverridingOptions.with_default_policies())
        # Diagnostics continue while simulated time stands still.
        self.create_timer(_DIAGNOSTICS_PERIOD, self._on_diagnostics,
                          clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.accept_changes()
        names = self._arm.predictor.stream.selector.names
        self.get_logger().info(
            f'predicting {names[0]} ... {names[-1]} from {self._subscription.topic_name}, '
            f'{self._arm.predictor.estimator.delay * 1000:.0f} ms behind the newest joint state; '
            f'parameters that differ from their defaults: {self.changed_settings()}')

    def build(self, values: dict[str, Any]) -> PredictorSettings:
        """Return the predictor's settings."""
        settings = PredictorSettings.from_parameters(values)
        settings.model.warm_up()
        return settings

    def apply(self, built: PredictorSettings) -> None:
        """Change the predictor's settings in mid-stream."""
        self._arm.configure(built)

    def _on_joint_state(self, message: JointState, info: dict[str, Any]) -> None:
        """Process a joint state and those queued behind it."""
        self._take(message, info)
        for waiting in take_waiting(self._subscription, _BATCH):
            self._take(*waiting)

    def _take(self, message: JointState, info: dict[str, Any]) -> None:
        self._loss.received(info.get('publication_sequence_number'))
        clock = self.get_clock()
        # The middleware's time of receipt does not include the time in the queue.
        received_ns = (clock.now().nanoseconds if clock.ros_time_is_active
                       else info['received_timestamp'])
        self._arm.take(stamp_ns(message.header), message.name, from_field(message.position),
                       from_field(message.velocity), from_field(message.effort), received_ns)

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        predictor = self._arm.predictor
        retimed = predictor.stream.clock.retimed
        self._arm.reset()
        response.success = True
        response.message = ('filter and contact detector are reset; predictions resume after '
                            f'{predictor.estimator.settling_time:.2f} s'
                            + ', once the period of the messages is known' * retimed)
        return response

    def _on_diagnostics(self) -> None:
        now = time.monotonic()
        period = now - self._last_report
        self._last_report = now
        message = DiagnosticArray()
        message.header.stamp = self.get_clock().now().to_msg()
        self._arm.statistics.close(self._arm.predictor.counts, period)
        message.status = report(self, self._subscription.topic_name, self._arm, self._loss)
        self._arm.statistics.begin()
        self._diagnostics.publish(message)
        for status in message.status:
            self._log(status)

    def _log(self, status: DiagnosticStatus) -> None:
        """Log a changed status, unless it is only the consequence of missing input."""
        name = status.name.partition(': ')[2]  # the log names the node
        level, text = self._logged.get(name, (DiagnosticStatus.OK, ''))
        if status.level == DiagnosticStatus.STALE and name != 'input' or (
                level, text) == (status.level, status.message):
            return
        if status.level != DiagnosticStatus.OK:
            self.get_logger().warning(f'{name}: {status.message}')
        elif level != DiagnosticStatus.OK:
            self.get_logger().info(f'{name}: {status.message}')
        self._logged[name] = status.level, status.message

    def _offer_services(self) -> None:
        try:
            from baxter_dynamics_interfaces.srv import GravityTorques, InverseDynamics
        except ImportError:
            self.get_logger().warning(
                'services gravity_torques and inverse_dynamics are not offered: the package '
                'baxter_dynamics_interfaces is not installed. Build it with colcon or run '
                '`pip install ./baxter_dynamics_interfaces`')
            return
        self._arm.offer_services(GravityTorques, InverseDynamics)


def main(args: list[str] | None = None) -> int:
    """Run the node until it is interrupted or terminated."""
    return run(TorquePredictor, 'torque_predictor', args)


if __name__ == '__main__':
    sys.exit(main())

"""The node: predicts an arm's effort from its joint states, and publishes the residual."""

import sys
import time

from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.clock import Clock
from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from . import parameters
from . import topics
from .diagnostics import PeriodStatistics
from .diagnostics import report
from .messages import from_field
from .messages import joint_state
from .messages import set_stamp
from .messages import stamp_ns
from .messages import to_field
from .process import run
from .services import Answers

_DIAGNOSTICS_PERIOD = 1.0  # [s]


class TorquePredictor(Node):
    """Predict the effort of a Baxter arm from its joint states, and publish the residual."""

    def __init__(self):
        super().__init__('torque_predictor')
        self._settings = parameters.declare(self)
        self._predictor = self._settings.predictor()
        self._last_taken = -float('inf')  # monotonic time of a valid joint state of the arm [s]
        self._last_prediction = -float('inf')  # monotonic time [s]
        self._statistics = PeriodStatistics()
        self._last_report = time.monotonic()
        self._reported = {}  # status name -> (level, message), to log changes

        names = self._predictor.intake.names
        self._predicted_message = joint_state(names, 0)
        self._residual_message = joint_state(names, 0)
        self._predicted = self.create_publisher(
            JointState, topics.PREDICTED_EFFORT, topics.PUBLISHER_QOS)
        self._residual = self.create_publisher(
            JointState, topics.EFFORT_RESIDUAL, topics.PUBLISHER_QOS)
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
        parameters.refuse_misspelt(self)
        self.add_on_set_parameters_callback(
            lambda changes: parameters.verdict(self._settings, changes))
        self.add_post_set_parameters_callback(self._on_parameters_set)
        self.get_logger().info(
            f'predicting {names[0]} ... {names[-1]} from {self._subscription.topic_name}, '
            f'{self._predictor.estimator.delay * 1000:.0f} ms behind the newest joint state')

    def _on_joint_state(self, message: JointState):
        predictor = self._predictor
        taken = predictor.counts['taken']
        prediction = predictor.handle(
            stamp_ns(message.header), message.name, from_field(message.position),
            from_field(message.velocity), from_field(message.effort))
        if predictor.counts['taken'] != taken:
            self._last_taken = time.monotonic()
        if prediction is None:
            return
        self._last_prediction = self._last_taken
        position, velocity = to_field(prediction.q), to_field(prediction.qd)
        self._publish(self._predicted, self._predicted_message, prediction.stamp_ns,
                      position, velocity, prediction.effort)
        if prediction.residual is not None:
            self._publish(self._residual, self._residual_message, prediction.stamp_ns,
                          position, velocity, prediction.residual)
        self._statistics.add(prediction.residual)

    @staticmethod
    def _publish(publisher, message, stamp, position, velocity, effort):
        set_stamp(message.header, stamp)
        message.position = position
        message.velocity = velocity
        message.effort = to_field(effort)
        publisher.publish(message)

    def _on_reset(self, request, response):
        self._predictor.reset()
        response.success = True
        response.message = ('filter state forgotten: predictions return after '
                            f'{self._predictor.estimator.settling_time:.2f} s')
        return response

    def _on_parameters_set(self, changes):
        settings = parameters.proposed(self._settings, changes)
        settings.configure(self._predictor, self._settings)
        self._settings = settings

    def _on_diagnostics(self):
        now = time.monotonic()
        period = now - self._last_report
        statuses = report(
            self.get_fully_qualified_name().lstrip('/'), self._subscription.topic_name,
            self._predictor, self._statistics, now - self._last_taken, period)
        self._statistics.clear(self._predictor.counts, period)
        self._last_report = now
        message = DiagnosticArray(status=statuses)
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(message)
        for status in statuses:
            said = status.level, status.message
            if self._reported.get(status.name) != said:
                self._log(status)
            self._reported[status.name] = said

    def _log(self, status: DiagnosticStatus):
        """Say a status that has changed in the log, too."""
        if status.level != DiagnosticStatus.OK:
            self.get_logger().warning(f'{status.name}: {status.message}')
        elif self._reported.get(status.name, (DiagnosticStatus.OK,))[0] != DiagnosticStatus.OK:
            self.get_logger().info(f'{status.name}: {status.message}')

    def _offer_services(self):
        try:
            from baxter_dynamics_interfaces.srv import GravityTorques, InverseDynamics
        except ImportError:
            self.get_logger().warning(
                'services gravity_torques and inverse_dynamics are off: their types are in the '
                'package baxter_dynamics_interfaces, which is not installed. It lies beside this '
                'one: build it with colcon, or `pip install ./baxter_dynamics_interfaces`')
            return
        answers = Answers(self._predictor, lambda: time.monotonic() - self._last_taken,
                          lambda: time.monotonic() - self._last_prediction)
        self.create_service(
            GravityTorques, topics.GRAVITY_TORQUES,
            lambda request, response: answers.gravity_torques(self._settings, request, response))
        self.create_service(
            InverseDynamics, topics.INVERSE_DYNAMICS,
            lambda request, response: answers.inverse_dynamics(self._settings, request, response))


def main(args=None):
    """Run the node until it is interrupted or terminated."""
    return run(TorquePredictor, 'torque_predictor', args)


if __name__ == '__main__':
    sys.exit(main())

"""Node torque_predictor: predicted effort, residual and external torque of one arm."""

from functools import partial
import sys
from typing import Any

from geometry_msgs.msg import InertiaStamped, WrenchStamped
import numpy as np
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from . import topics
from .calibrate_action import CalibrateAction
from .diagnostic_updater import DiagnosticUpdater
from .diagnostics import PredictorDiagnostics
from .messages import from_field, joint_state, set_stamp, set_vector, stamp_ns, to_field
from .process import run
from .rclpy_internals import take_waiting
from .ros_parameters import ParameterNode
from .services import DynamicsServices
from .step_statistics import StepStatistics
from .zero import ZeroService
from ..estimation.explanation import PayloadEstimate, ResidualExplainer
from ..estimation.external import External, hand_wrench
from ..estimation.predictor import Predictor, Step
from ..estimation.settings import PredictorSettings, SETTINGS

_BATCH = 30  # maximum number of joint states per callback, so that other callbacks run
_TYPES = {topics.PREDICTED_EFFORT: JointState, topics.EFFORT_RESIDUAL: JointState,
          topics.RESIDUAL_DEVIATION: JointState, topics.EXTERNAL_EFFORT: JointState,
          topics.EXTERNAL_WRENCH: WrenchStamped, topics.CONTACT: Bool,
          topics.PAYLOAD_ESTIMATE: InertiaStamped}


class ResultPublishers:
    """Publishers of the results of one arm; results without subscribers are not published."""

    def __init__(self, node: ParameterNode, predictor: Predictor,
                 statistics: StepStatistics) -> None:
        settings = predictor.settings
        self._predictor = predictor
        self._statistics = statistics
        self._has_hand_axes = settings.wrench_frame == 'hand'
        self._hand = f'{settings.arm}_hand'
        self._publishers = {name: node.create_publisher(kind, f'~/{name}', topics.PUBLISHER_QOS)
                            for name, kind in _TYPES.items()}
        # Messages are reused: rclpy copies them when it publishes.
        self._joint_state = joint_state(predictor.stream.selector.names, 0)
        self._wrench = WrenchStamped()
        self._joint_state.header.frame_id = settings.frame_id
        self._wrench.header.frame_id = self._hand if self._has_hand_axes else settings.frame_id

    def publish(self, step: Step) -> None:
        """Publish the results of a joint state."""
        message, external = self._joint_state, step.external
        for result, efforts in step.efforts():
            set_stamp(message.header, result.stamp_ns)
            message.position, message.velocity = to_field(result.q), to_field(result.qd)
            for topic, effort in efforts.items():
                if self._has_subscriber(topic):
                    message.effort = to_field(effort)
                    self._publishers[topic].publish(message)
        if external is not None:
            if external.contact is not None and self._has_subscriber(topics.CONTACT):
                self._publishers[topics.CONTACT].publish(Bool(data=external.contact))
            if self._has_subscriber(topics.EXTERNAL_WRENCH):
                self._publish_wrench(external)

    def publish_payload(self, payload: PayloadEstimate, stamp_ns: int) -> None:
        """Publish a payload that explains the residual; its inertia is not known."""
        message = InertiaStamped()
        set_stamp(message.header, stamp_ns)
        message.header.frame_id = self._hand
        message.inertia.m = payload.mass
        set_vector(message.inertia.com, payload.center_of_mass)
        self._publishers[topics.PAYLOAD_ESTIMATE].publish(message)

    def _has_subscriber(self, topic: str) -> bool:
        return self._publishers[topic].get_subscription_count() > 0

    def _publish_wrench(self, external: External) -> None:
        arm = self._predictor.model.arm
        wrench = hand_wrench(arm.jacobian(external.q), external.effort)
        self._statistics.add_wrench(wrench)
        if wrench is not None:
            message = self._wrench
            set_stamp(message.header, external.stamp_ns)
            axes = (arm.forward_kinematics(external.q)[:3, :3] if self._has_hand_axes
                    else np.eye(3))
            set_vector(message.wrench.force, wrench.force @ axes)
            set_vector(message.wrench.torque, wrench.torque @ axes)
            self._publishers[topics.EXTERNAL_WRENCH].publish(message)


class TorquePredictor(ParameterNode):
    """Predicts one arm's effort and estimates the external torque."""

    def __init__(self) -> None:
        super().__init__('torque_predictor')
        self._predictor = Predictor(self.declare_settings(SETTINGS), external=True)
        self._statistics = StepStatistics()
        self._results = ResultPublishers(self, self._predictor, self._statistics)
        self.create_service(Trigger, f'~/{topics.RESET}', self._on_reset)
        self._zero = ZeroService(self, self._predictor, self._statistics)
        self.create_service(
            Trigger, f'~/{topics.ZERO}', self._zero.handle, callback_group=self._zero.group)
        self._calibrate: CalibrateAction | None = None
        self._offer_own_types()
        self._subscription = self.create_subscription(
            JointState, topics.JOINT_STATES, self._on_joint_state, topics.SUBSCRIPTION_QOS,
            event_callbacks=SubscriptionEventCallbacks(
                matched=lambda info: self._statistics.loss.matched(info.total_count_change)),
            qos_overriding_options=QoSOverridingOptions.with_default_policies())
        topic, selector = self._subscription.topic_name, self._predictor.stream.selector
        model = self._predictor.model
        self._explainer = ResidualExplainer(model.arm, model.effort_model)
        DiagnosticUpdater(self, f'baxter_{selector.side}_arm', PredictorDiagnostics(
            self, topic, self._predictor, self._statistics, self._explain).report)
        self.check_given_names()
        self.get_logger().info(
            f'predicting {selector.names[0]} ... {selector.names[-1]} from {topic}, '
            f'{self._predictor.estimator.delay * 1000:.0f} ms behind the newest joint state; '
            f'{self.changed_settings()}')

    def build(self, values: dict[str, Any]) -> PredictorSettings:
        """Return the predictor's settings."""
        return PredictorSettings.from_parameters(values)

    def apply(self, built: PredictorSettings) -> None:
        """Change the predictor's settings in mid-stream."""
        before = self._predictor.model
        self._predictor.configure(built)
        model = self._predictor.model
        if model is not before:
            self._explainer.configure(model.arm, model.effort_model)

    def destroy_node(self) -> None:
        """End a fit that is running, then destroy the node."""
        if self._calibrate is not None:
            self._calibrate.destroy()
        super().destroy_node()

    def _on_joint_state(self, message: JointState, info: dict[str, Any]) -> None:
        """Process a joint state and those queued behind it."""
        self._take(message, info)
        for waiting in take_waiting(self._subscription, _BATCH):
            self._take(*waiting)

    def _take(self, message: JointState, info: dict[str, Any]) -> None:
        self._statistics.loss.received(info.get('publication_sequence_number'))
        clock = self.get_clock()
        # The middleware's time of receipt does not include the time in the queue.
        received_ns = (clock.now().nanoseconds if clock.ros_time_is_active
                       else info['received_timestamp'])
        step = self._predictor.handle(
            stamp_ns(message.header), message.name, from_field(message.position),
            from_field(message.velocity), from_field(message.effort), received_ns)
        self._statistics.add(step)
        self._results.publish(step)
        self._zero.add(step)
        if step.prediction is not None:
            self._explainer.add(step.prediction, step.external and step.external.contact)
        if self._calibrate is not None:
            self._calibrate.add(message, received_ns, step)

    def _explain(self) -> str:
        """Explain the residual, and publish a payload that would cause it."""
        explained, prediction = self._explainer.explain(), self._statistics.predicted.prediction
        if explained.payload is not None and prediction is not None:
            self._results.publish_payload(explained.payload, prediction.stamp_ns)
        return explained.text

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        retimed = self._predictor.stream.clock.retimed
        self._predictor.reset()
        self._statistics.predicted = Step()
        self._explainer.reset()
        response.success = True
        response.message = ('filter and contact detector are reset; predictions resume after '
                            f'{self._predictor.estimator.settling_time:.2f} s'
                            + ', once the period of the messages is known' * retimed)
        return response

    def _offer_own_types(self) -> None:
        try:
            from baxter_dynamics_interfaces.action import Calibrate
            from baxter_dynamics_interfaces.srv import GravityTorques, InverseDynamics
        except ImportError as error:
            self.get_logger().warning(
                'services gravity_torques and inverse_dynamics and the action calibrate are not '
                f'offered: the package baxter_dynamics_interfaces cannot be imported ({error}). '
                'Build it with colcon or run `pip install ./baxter_dynamics_interfaces`')
            return
        self._calibrate = CalibrateAction(self, self._predictor, self._statistics, Calibrate)
        services = DynamicsServices(self._predictor, self._statistics)
        self.create_service(
            GravityTorques, f'~/{topics.GRAVITY_TORQUES}', services.gravity_torques)
        self.create_service(
            InverseDynamics, f'~/{topics.INVERSE_DYNAMICS}', services.inverse_dynamics)


main = partial(run, TorquePredictor, 'torque_predictor')

if __name__ == '__main__':
    sys.exit(main())

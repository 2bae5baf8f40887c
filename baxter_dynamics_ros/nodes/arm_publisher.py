"""Stream handler, publishers and services of one arm."""

from collections.abc import Sequence
from typing import Any, cast

from geometry_msgs.msg import WrenchStamped
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from . import topics
from .messages import joint_state, set_stamp, set_vector, to_field
from .period import PeriodStatistics
from .services import DynamicsServices, RecentSteps
from ..estimation.external import External, ExternalEffort
from ..estimation.predictor import Prediction, Predictor
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array


class Arm:
    """
    Stream handler, publishers and services of one arm.

    Results without subscribers are not published.

    Parameters
    ----------
    node : Node
        Node that owns the publishers and services.
    settings : PredictorSettings
        Settings of the arm.

    Attributes
    ----------
    predictor : Predictor
        Handler of the joint states.
    external : ExternalEffort
        Estimator of the external torque, part of the predictor.
    statistics : PeriodStatistics
        Counts and sums since the last diagnostics.
    recent : RecentSteps
        Newest results of the predictor.

    """

    def __init__(self, node: Node, settings: PredictorSettings) -> None:
        self.predictor = Predictor(settings, external=True)
        self.external = cast(ExternalEffort, self.predictor.external)  # not None
        self.statistics = PeriodStatistics()
        self.recent = RecentSteps()
        self._node = node
        self._prediction = self._publisher(JointState, topics.PREDICTED_EFFORT)
        self._residual = self._publisher(JointState, topics.EFFORT_RESIDUAL)
        self._external = self._publisher(JointState, topics.EXTERNAL_EFFORT)
        self._wrench = self._publisher(WrenchStamped, topics.EXTERNAL_WRENCH)
        self._contact = self._publisher(Bool, topics.CONTACT)
        # Messages are reused: rclpy copies them when it publishes.
        self._joint_state = joint_state(self.predictor.stream.selector.names, 0)
        self._wrench_stamped = WrenchStamped()
        for message in (self._joint_state, self._wrench_stamped):
            message.header.frame_id = settings.frame_id
        self._bool = Bool()

    def take(self, stamp_ns: int, names: Sequence[str], position: Array, velocity: Array,
             effort: Array, received_ns: int) -> None:
        """Process a joint state (see :meth:`.Predictor.handle`) and publish the results."""
        step = self.predictor.handle(stamp_ns, names, position, velocity, effort, received_ns)
        self.recent.add(step)
        if step.prediction is not None:
            self._publish_prediction(step.prediction)
        if step.external is not None:
            self._publish_external(step.external)

    def reset(self) -> None:
        """Forget the stream and everything learned about free motion."""
        self.predictor.reset()
        self.recent.predicted = None

    def configure(self, settings: PredictorSettings) -> None:
        """Change the settings in mid-stream."""
        self.predictor.configure(settings)

    def offer_services(self, gravity_torques: type[Any], inverse_dynamics: type[Any]) -> None:
        """Offer the services of these types."""
        services = DynamicsServices(self.predictor, self.recent)
        self._node.create_service(
            gravity_torques, topics.below_node(topics.GRAVITY_TORQUES),
            lambda request, response: services.gravity_torques(request, response))
        self._node.create_service(
            inverse_dynamics, topics.below_node(topics.INVERSE_DYNAMICS),
            lambda request, response: services.inverse_dynamics(request, response))

    def _publish_prediction(self, prediction: Prediction) -> None:
        self.statistics.add(prediction.residual)
        self._prepare(prediction)
        self._publish(self._prediction, prediction.effort)
        if prediction.residual is not None:
            self._publish(self._residual, prediction.residual)

    def _publish_external(self, external: External) -> None:
        if external.contact:
            self.statistics.add_contact(external.joints)
        if self._external.get_subscription_count():
            self._prepare(external)
            self._publish(self._external, external.effort)
        if external.contact is not None and self._contact.get_subscription_count():
            self._bool.data = external.contact
            self._contact.publish(self._bool)
        if self._wrench.get_subscription_count():
            wrench = self.external.wrench(external)
            self.statistics.add_wrench(wrench)
            if wrench is not None:
                message = self._wrench_stamped
                set_stamp(message.header, external.stamp_ns)
                set_vector(message.wrench.force, wrench.force)
                set_vector(message.wrench.torque, wrench.torque)
                self._wrench.publish(message)

    def _prepare(self, result: Prediction | External) -> None:
        """Set stamp, position and velocity of the message."""
        message = self._joint_state
        set_stamp(message.header, result.stamp_ns)
        message.position = to_field(result.q)
        message.velocity = to_field(result.qd)

    def _publish(self, publisher: Publisher, effort: Array) -> None:
        """Publish the prepared message with the given effort."""
        if publisher.get_subscription_count():
            self._joint_state.effort = to_field(effort)
            publisher.publish(self._joint_state)

    def _publisher(self, kind: type[Any], name: str) -> Publisher:
        # rclpy's default event handlers cost time with every message.
        return self._node.create_publisher(
            kind, topics.below_node(name), topics.PUBLISHER_QOS,
            event_callbacks=PublisherEventCallbacks(use_default_callbacks=False))

"""Publishers of the results of one arm."""

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
from ..estimation.external import External, ExternalEffort
from ..estimation.predictor import Prediction, Predictor, Step
from ..model.arrays import Array


class ResultPublishers:
    """
    Publishers of the results of one arm; results without subscribers are not published.

    Parameters
    ----------
    node : Node
        Node that owns the publishers.
    predictor : Predictor
        Source of the results.
    statistics : PeriodStatistics
        Counts the wrenches.
    frame_id : str
        Frame of the messages.

    """

    def __init__(self, node: Node, predictor: Predictor, statistics: PeriodStatistics,
                 frame_id: str) -> None:
        self._node = node
        self._statistics = statistics
        self._external_effort = cast(ExternalEffort, predictor.external)
        self._prediction = self._publisher(JointState, topics.PREDICTED_EFFORT)
        self._residual = self._publisher(JointState, topics.EFFORT_RESIDUAL)
        self._external = self._publisher(JointState, topics.EXTERNAL_EFFORT)
        self._wrench = self._publisher(WrenchStamped, topics.EXTERNAL_WRENCH)
        self._contact = self._publisher(Bool, topics.CONTACT)
        # Messages are reused: rclpy copies them when it publishes.
        self._joint_state = joint_state(predictor.stream.selector.names, 0)
        self._wrench_stamped = WrenchStamped()
        for message in (self._joint_state, self._wrench_stamped):
            message.header.frame_id = frame_id
        self._bool = Bool()

    def publish(self, step: Step) -> None:
        """Publish the results of a joint state."""
        prediction, external = step.prediction, step.external
        if prediction is not None:
            self._prepare(prediction)
            self._publish(self._prediction, prediction.effort)
            if prediction.residual is not None:
                self._publish(self._residual, prediction.residual)
        if external is not None:
            self._prepare(external)
            self._publish(self._external, external.effort)
            if external.contact is not None and self._contact.get_subscription_count():
                self._bool.data = external.contact
                self._contact.publish(self._bool)
            if self._wrench.get_subscription_count():
                self._publish_wrench(external)

    def _publish_wrench(self, external: External) -> None:
        wrench = self._external_effort.wrench(external)
        self._statistics.add_wrench(wrench)
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
            kind, f'~/{name}', topics.PUBLISHER_QOS,
            event_callbacks=PublisherEventCallbacks(use_default_callbacks=False))

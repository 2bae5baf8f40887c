"""Publishers of the results of one arm."""

from typing import Any, cast

from geometry_msgs.msg import InertiaStamped, WrenchStamped
import numpy as np
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from . import topics
from .messages import joint_state, set_stamp, set_vector, to_field
from .period import PeriodStatistics
from ..estimation.explanation import PayloadEstimate
from ..estimation.external import External, ExternalEffort
from ..estimation.predictor import Prediction, Predictor, Step
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array


class ResultPublishers:
    """Publishers of the results of one arm; results without subscribers are not published."""

    def __init__(self, node: Node, predictor: Predictor, statistics: PeriodStatistics,
                 settings: PredictorSettings) -> None:
        self._node = node
        self._predictor = predictor
        self._statistics = statistics
        self._has_hand_axes = settings.wrench_frame == 'hand'
        self._external_effort = cast(ExternalEffort, predictor.external)
        self._prediction = self._publisher(JointState, topics.PREDICTED_EFFORT)
        self._residual = self._publisher(JointState, topics.EFFORT_RESIDUAL)
        self._deviation = self._publisher(JointState, topics.RESIDUAL_DEVIATION)
        self._external = self._publisher(JointState, topics.EXTERNAL_EFFORT)
        self._wrench = self._publisher(WrenchStamped, topics.EXTERNAL_WRENCH)
        self._contact = self._publisher(Bool, topics.CONTACT)
        self._payload = self._publisher(InertiaStamped, topics.PAYLOAD_ESTIMATE)
        # Messages are reused: rclpy copies them when it publishes.
        self._joint_state = joint_state(predictor.stream.selector.names, 0)
        self._wrench_stamped = WrenchStamped()
        self._bool = Bool()
        self._hand = f'{settings.arm}_hand'
        self._joint_state.header.frame_id = settings.frame_id
        self._wrench_stamped.header.frame_id = (
            self._hand if self._has_hand_axes else settings.frame_id)

    def publish(self, step: Step) -> None:
        """Publish the results of a joint state."""
        prediction, external = step.prediction, step.external
        if prediction is not None:
            self._prepare(prediction)
            self._publish(self._prediction, prediction.effort)
            if prediction.residual is not None:
                self._publish(self._residual, prediction.residual)
                self._publish(self._deviation, prediction.deviation)
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
            axes = (self._predictor.model.arm.forward_kinematics(external.q)[:3, :3]
                    if self._has_hand_axes else np.eye(3))
            set_vector(message.wrench.force, wrench.force @ axes)
            set_vector(message.wrench.torque, wrench.torque @ axes)
            self._wrench.publish(message)

    def publish_payload(self, payload: PayloadEstimate, stamp_ns: int) -> None:
        """Publish a payload that explains the residual; its inertia is not known."""
        message = InertiaStamped()
        set_stamp(message.header, stamp_ns)
        message.header.frame_id = self._hand
        message.inertia.m = payload.mass
        set_vector(message.inertia.com, payload.center_of_mass)
        self._payload.publish(message)

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

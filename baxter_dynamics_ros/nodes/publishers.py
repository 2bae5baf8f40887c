"""Publishers of the results of one arm."""

from typing import cast

from geometry_msgs.msg import InertiaStamped, WrenchStamped
import numpy as np
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from . import topics
from .messages import joint_state, set_stamp, set_vector, to_field
from .step_statistics import StepStatistics
from ..estimation.explanation import PayloadEstimate
from ..estimation.external import External, ExternalEffort
from ..estimation.predictor import Prediction, Predictor, Step
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array

_TYPES = {topics.PREDICTED_EFFORT: JointState, topics.EFFORT_RESIDUAL: JointState,
          topics.RESIDUAL_DEVIATION: JointState, topics.EXTERNAL_EFFORT: JointState,
          topics.EXTERNAL_WRENCH: WrenchStamped, topics.CONTACT: Bool,
          topics.PAYLOAD_ESTIMATE: InertiaStamped}


class ResultPublishers:
    """Publishers of the results of one arm; results without subscribers are not published."""

    def __init__(self, node: Node, predictor: Predictor, statistics: StepStatistics,
                 settings: PredictorSettings) -> None:
        self._predictor = predictor
        self._statistics = statistics
        self._has_hand_axes = settings.wrench_frame == 'hand'
        self._hand = f'{settings.arm}_hand'
        # rclpy's default event handlers cost time with every message.
        self._publishers = {name: node.create_publisher(
            kind, f'~/{name}', topics.PUBLISHER_QOS,
            event_callbacks=PublisherEventCallbacks(use_default_callbacks=False))
            for name, kind in _TYPES.items()}
        # Messages are reused: rclpy copies them when it publishes.
        self._joint_state = joint_state(predictor.stream.selector.names, 0)
        self._wrench = WrenchStamped()
        self._joint_state.header.frame_id = settings.frame_id
        self._wrench.header.frame_id = self._hand if self._has_hand_axes else settings.frame_id

    def publish(self, step: Step) -> None:
        """Publish the results of a joint state."""
        prediction, external = step.prediction, step.external
        if prediction is not None:
            efforts = {topics.PREDICTED_EFFORT: prediction.effort}
            if prediction.residual is not None:
                efforts |= {topics.EFFORT_RESIDUAL: prediction.residual,
                            topics.RESIDUAL_DEVIATION: prediction.deviation}
            self._publish_efforts(prediction, efforts)
        if external is not None:
            self._publish_efforts(external, {topics.EXTERNAL_EFFORT: external.effort})
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

    def _publish_efforts(self, result: Prediction | External, efforts: dict[str, Array]) -> None:
        """Publish efforts by topic, with the stamp, position and velocity of a result."""
        message = self._joint_state
        set_stamp(message.header, result.stamp_ns)
        message.position, message.velocity = to_field(result.q), to_field(result.qd)
        for topic, effort in efforts.items():
            if self._has_subscriber(topic):
                message.effort = to_field(effort)
                self._publishers[topic].publish(message)

    def _publish_wrench(self, external: External) -> None:
        wrench = cast(ExternalEffort, self._predictor.external).wrench(external)
        self._statistics.add_wrench(wrench)
        if wrench is not None:
            message = self._wrench
            set_stamp(message.header, external.stamp_ns)
            axes = (self._predictor.model.arm.forward_kinematics(external.q)[:3, :3]
                    if self._has_hand_axes else np.eye(3))
            set_vector(message.wrench.force, wrench.force @ axes)
            set_vector(message.wrench.torque, wrench.torque @ axes)
            self._publishers[topics.EXTERNAL_WRENCH].publish(message)

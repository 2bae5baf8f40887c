"""One arm of the node: its stream handler, what it publishes, and the services that it answers."""

from collections.abc import Sequence
import time
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
from .services import Answers
from ..estimation.external import External, ExternalEffort
from ..estimation.predictor import Prediction
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array


class Arm:
    """
    Publishes what one arm needs and what pushes it.

    What nobody listens to is not published, nor made.

    Parameters
    ----------
    node : Node
        Whose.
    settings : PredictorSettings
        Of the arm.

    Attributes
    ----------
    predictor : Predictor
        The stream handler.
    external : ExternalEffort
        Its part that tells what pushes the arm.
    settings : PredictorSettings
        As they are.
    statistics : PeriodStatistics
        Of what came since the last report.

    """

    def __init__(self, node: Node, settings: PredictorSettings) -> None:
        self.settings = settings
        self.predictor = settings.predictor(external=True)
        self.external = cast(ExternalEffort, self.predictor.external)  # as was asked for
        self.statistics = PeriodStatistics()
        self._taken = -float('inf')  # monotonic time of a valid joint state of the arm [s]
        self._predicted = -float('inf')  # monotonic time [s]
        self._node = node
        self._prediction = self._publisher(JointState, topics.PREDICTED_EFFORT)
        self._residual = self._publisher(JointState, topics.EFFORT_RESIDUAL)
        self._external = self._publisher(JointState, topics.EXTERNAL_EFFORT)
        self._wrench = self._publisher(WrenchStamped, topics.EXTERNAL_WRENCH)
        self._contact = self._publisher(Bool, topics.CONTACT)
        # One message of each kind, filled anew each time: rclpy copies what it publishes.
        self._joint_state = joint_state(self.predictor.stream.selector.names, 0)
        self._wrench_stamped = WrenchStamped()
        for message in (self._joint_state, self._wrench_stamped):
            message.header.frame_id = settings.values['frame_id']
        self._bool = Bool()

    @property
    def age(self) -> float:
        """Time since the arm's last valid joint state [s]; infinite if there was none."""
        return time.monotonic() - self._taken

    @property
    def prediction_age(self) -> float:
        """Time since the last prediction [s]; infinite if there was none."""
        return time.monotonic() - self._predicted

    def take(self, stamp_ns: int, names: Sequence[str], position: Array, velocity: Array,
             effort: Array, received_ns: int) -> None:
        """Process a joint state, as the stream handler does, and publish the results."""
        predictor = self.predictor
        taken = predictor.counts['taken']
        prediction = predictor.handle(stamp_ns, names, position, velocity, effort, received_ns)
        if predictor.counts['taken'] != taken:
            self._taken = time.monotonic()
        if prediction is not None:
            self._predicted = self._taken
            self._tell_prediction(prediction)
        external = self.external.latest
        if external is not None:
            self._tell_external(external)

    def configure(self, settings: PredictorSettings) -> None:
        """Change the settings in mid-stream."""
        settings.configure(self.predictor, self.settings)
        self.settings = settings

    def offer_services(self, gravity_torques: type[Any], inverse_dynamics: type[Any]) -> None:
        """Answer services of these types."""
        answers = Answers(self.predictor, lambda: self.age, lambda: self.prediction_age)
        self._node.create_service(
            gravity_torques, topics.below_node(topics.GRAVITY_TORQUES),
            lambda request, response: answers.gravity_torques(self.settings, request, response))
        self._node.create_service(
            inverse_dynamics, topics.below_node(topics.INVERSE_DYNAMICS),
            lambda request, response: answers.inverse_dynamics(self.settings, request, response))

    def _tell_prediction(self, prediction: Prediction) -> None:
        self.statistics.add(prediction.residual)
        self._prepare(prediction)
        self._publish(self._prediction, prediction.effort)
        if prediction.residual is not None:
            self._publish(self._residual, prediction.residual)

    def _tell_external(self, external: External) -> None:
        if external.contact:
            self.statistics.add_contact(self.external.detector.joints)
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
        """Put the instant and the motion of a prediction or external effort into the message."""
        message = self._joint_state
        set_stamp(message.header, result.stamp_ns)
        message.position = to_field(result.q)
        message.velocity = to_field(result.qd)

    def _publish(self, publisher: Publisher, effort: Array) -> None:
        """Publish the prepared message with an effort."""
        if publisher.get_subscription_count():
            self._joint_state.effort = to_field(effort)
            publisher.publish(self._joint_state)

    def _publisher(self, kind: type[Any], name: str) -> Publisher:
        # Of rclpy's event handlers, two a publisher, each costs something with every message.
        return self._node.create_publisher(
            kind, topics.below_node(name), topics.PUBLISHER_QOS,
            event_callbacks=PublisherEventCallbacks(use_default_callbacks=False))

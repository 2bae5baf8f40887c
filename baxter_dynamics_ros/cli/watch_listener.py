"""The node that listens: it takes what waits on the topics, and says what of it is missing."""

from __future__ import annotations

import math
import os
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.validate_full_topic_name import validate_full_topic_name
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from .watch_data import Status, Watched
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import SIDES
from ..nodes import topics
from ..nodes.messages import from_field, stamp_ns

_PREDICTED = '/' + topics.PREDICTED_EFFORT
_LOOK_EVERY = 0.5  # [s] between two looks at the graph, while nothing comes
# Attribute of ArmData -> topic. Residuals first: their prediction has then come, too.
_EFFORTS = {'residual': topics.EFFORT_RESIDUAL, 'predicted': topics.PREDICTED_EFFORT,
            'external': topics.EXTERNAL_EFFORT}


class Listener:
    """
    Subscribes to a predictor as any tool would, as sensor data: it never holds the predictor up.

    Messages are taken from the middleware when ``listen`` is called, all that wait, without an
    executor: that costs a tenth of a callback each.

    Parameters
    ----------
    predictor : str
        The predictor's name, with its namespace.
    side : str or None
        The only arm to listen to.
    joint_states : str
        The topic of the robot's joint states.

    Raises
    ------
    BaxterDynamicsError
        If a name is none.

    """

    def __init__(self, predictor: str, side: str | None, joint_states: str) -> None:
        self.watched = Watched()
        self.predictor = '/' + predictor.strip('/')
        self._side = side
        self._there: set[str] = set()  # the predictors in the graph
        self._looked = -math.inf  # when, monotonic time [s]
        self._joint_states = joint_states
        self._node = Node(f'watch_{os.getpid()}', enable_rosout=False,
                          start_parameter_services=False)
        _refuse('--node', self.predictor)
        _refuse('--topic', joint_states)
        self._robot = self._subscribe(JointState, joint_states)
        self._diagnostics = self._subscribe(DiagnosticArray, topics.DIAGNOSTICS)
        self._efforts, self._contacts = [], []
        for place in ('', *((side,) if side else SIDES)):
            below = '/'.join(filter(None, (self.predictor, place)))
            self._efforts += [(place, topic, self._subscribe(JointState, f'{below}/{name}'))
                              for topic, name in _EFFORTS.items()]
            self._contacts.append((place, self._subscribe(Bool, f'{below}/{topics.CONTACT}')))

    def listen(self, now: float) -> None:
        """Take all that waits, as come at monotonic time now [s]."""
        for place, topic, subscription in self._efforts:
            for message in _waiting(subscription, JointState):
                self.watched.take_effort(place, topic, message.name, from_field(message.effort),
                                         stamp_ns(message.header), now)
        for place, subscription in self._contacts:
            for message in _waiting(subscription, Bool):
                self.watched.take_contact(place, message.data, now)
        # After the residuals, so that none is ahead of them.
        for message in _waiting(self._robot, JointState):
            self.watched.take_joint_state(
                message.name, from_field(message.effort), stamp_ns(message.header), now)
        for message in _waiting(self._diagnostics, DiagnosticArray):
            for status in message.status:
                self._take_status(status, now)

    def missing(self, now: float) -> str | None:
        """Return what is missing and the remedy, in one line; None where predictions arrive."""
        arms = self.watched.shown(self._side)
        if any(arm.predicted.is_live(now) for arm in arms):
            return None
        if now - self._looked > _LOOK_EVERY:
            self._looked, self._there = now, self._predictors()
        there = self._there
        if self.predictor not in there:
            others = ', '.join(sorted(there))
            return (f'no predictor {self.predictor} in ROS domain '
                    f'{os.environ.get("ROS_DOMAIN_ID") or 0}: is torque_predictor running, with '
                    'the same ROS_DOMAIN_ID?' + (f' --node may name {others}' if others else ''))
        sides = {arm.side for arm in self.watched.shown()}
        if self._side and sides and self._side not in sides:
            return (f'{self.predictor} predicts the {sides.pop()} arm, not the {self._side}: '
                    f'start it with arm:={self._side}, or choose the other --arm')
        said = [arm.statuses[name].message for arm in arms for name in ('input', 'filter')
                if name in arm.statuses and arm.statuses[name].level]
        return f'{self.predictor} runs, but predicts nothing: ' + (
            said[0] if said else f'do joint states come on {self._joint_states}? '
            'Its diagnostics will say')

    def _predictors(self) -> set[str]:
        """Return the names of the predictors there are."""
        there = set()
        for topic, _ in self._node.get_topic_names_and_types():
            if topic.endswith(_PREDICTED) and self._node.count_publishers(topic):
                name = topic.removesuffix(_PREDICTED)
                there.add(next((name.removesuffix(f'/{side}') for side in SIDES
                                if name.endswith(f'/{side}')), name))
        return there

    def _take_status(self, status: Any, now: float) -> None:
        whose, _, name = status.name.partition(': ')
        place = whose.removeprefix(self.predictor.lstrip('/'))
        if name and place in ('', *(f'/{side}' for side in SIDES)) and place != whose:
            self.watched.take_status(place.lstrip('/'), name, Status(
                int.from_bytes(status.level, 'little'), status.message,
                {pair.key: pair.value for pair in status.values}, now), status.hardware_id)

    def _subscribe(self, kind: type, topic: str) -> Any:
        return self._node.create_subscription(
            kind, topic, lambda message: None, topics.SUBSCRIPTION_QOS)


def _waiting(subscription: Any, kind: type) -> list[Any]:
    """Take the messages that wait, but no more than there is room for: some come meanwhile."""
    messages = []
    for _ in range(topics.SUBSCRIPTION_QOS.depth):
        taken = subscription.handle.take_message(kind, False)
        if taken is None:
            break
        messages.append(taken[0])
    return messages


def _refuse(option: str, name: str) -> None:
    try:
        validate_full_topic_name(name)
    except InvalidTopicNameException as error:
        raise BaxterDynamicsError(f'{option}: {" ".join(str(error).split())}') from None

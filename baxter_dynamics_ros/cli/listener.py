"""ROS node of a command, which receives messages in batches."""

from collections.abc import Callable
import os
import signal
import time
from typing import Any

import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState

from ..model import Array, BaxterDynamicsError
from ..nodes import topics
from ..nodes.messages import from_field, stamp_ns
from ..nodes.rclpy_internals import take_waiting

# Stamp [ns], names, position, velocity and effort of a joint state.
Received = tuple[int, list[str], Array, Array, Array]

_BATCH_PERIOD = 0.03  # [s]; an executor would wake for every message, at most of a core
_MAX_BATCH = 1000  # messages of a topic
_SERVICE = 10.0  # timeout of a service [s]


class Listener:
    """
    A node that subscribes to topics; a context manager that shuts ROS down.

    Inside it, SIGINT, SIGTERM and SIGHUP take effect when it waits for messages: within a call of
    rclpy their exception would be lost or become another one. A second signal acts at once.
    Raises BaxterDynamicsError if ROS does not start or the name of a topic is invalid.
    """

    def __init__(self, name: str, namespace: str = '') -> None:
        self._subscriptions: list[Subscription] = []
        self._handlers: dict[int, Any] = {}  # of signals, outside the context
        self._signal: int | None = None  # received, but not handled yet
        try:
            # Without the signal handlers of rclpy, Ctrl-C raises KeyboardInterrupt.
            rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
            self.node = Node(f'{name}_{os.getpid()}', namespace=namespace, enable_rosout=False,
                             start_parameter_services=False)
        except RuntimeError as error:  # such as an invalid ROS_DOMAIN_ID
            raise BaxterDynamicsError(f'ROS does not start: {error}') from None

    def __enter__(self) -> 'Listener':
        """Return this listener."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if callable(signal.getsignal(number)):
                self._handlers[number] = signal.signal(number, self._defer)
        return self

    def __exit__(self, *exception: object) -> None:
        """Shut ROS down."""
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        rclpy.try_shutdown()

    def _defer(self, number: int, frame: Any) -> None:
        if self._signal is not None:
            self._handlers[number](number, frame)
        self._signal = number

    def subscribe(self, kind: type, topic: str, receive: Callable[[Any], object]) -> None:
        """Call a function with each message of a topic."""
        try:
            self._subscriptions.append(self.node.create_subscription(
                kind, topic, receive, topics.SUBSCRIPTION_QOS))
        except InvalidTopicNameException as error:
            raise BaxterDynamicsError(f'topic {topic}: {" ".join(str(error).split())}') from None

    def unsubscribe(self) -> None:
        """Drop all subscriptions."""
        while self._subscriptions:
            self.node.destroy_subscription(self._subscriptions.pop())

    def joint_states(self, topic: str) -> list[Received]:
        """Subscribe to joint states; return the list that receives them."""
        states: list[Received] = []
        self.subscribe(JointState, topic, lambda message: states.append((
            stamp_ns(message.header), message.name, *map(from_field, (
                message.position, message.velocity, message.effort)))))
        return states

    def predictors(self) -> set[str]:
        """Return the names of the running predictors."""
        ending = '/' + topics.PREDICTED_EFFORT
        return {name.removesuffix(ending) for name, _ in self.node.get_topic_names_and_types()
                if name.endswith(ending) and self.node.count_publishers(name)}

    def wait(self, condition: Callable[[], object], seconds: float) -> bool:
        """Receive messages for a time [s], or until a condition holds; return whether it does."""
        limit = time.monotonic() + seconds
        while True:
            if self._signal is not None:
                self._handlers[self._signal](self._signal, None)
            holds, left = bool(condition()), limit - time.monotonic()
            if holds or left <= 0.0:
                return holds
            time.sleep(min(left, _BATCH_PERIOD))
            for subscription in self._subscriptions:
                for message, _ in take_waiting(subscription, _MAX_BATCH):
                    subscription.callback(message)

    def call(self, kind: type[Any], name: str) -> Any:
        """Return the answer of a service to an empty request; None if there is none."""
        client = self.node.create_client(kind, name)
        if not client.wait_for_service(timeout_sec=_SERVICE):
            return None
        future = client.call_async(kind.Request())
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=_SERVICE)
        return future.result()

"""Access to private parts of rclpy, each covered by a test."""

from collections.abc import Iterator
from typing import Any

from rclpy.node import Node
from rclpy.subscription import Subscription


def take_waiting(subscription: Subscription, limit: int) -> Iterator[tuple[Any, dict[str, Any]]]:
    """
    Yield up to ``limit`` messages that wait in the middleware, with their message info.

    An executor takes one message of a subscription per cycle through all services and timers,
    which costs most of a core at 1000 Hz.
    """
    for _ in range(limit):
        waiting = subscription.handle.take_message(subscription.msg_type, False)
        if waiting is None:
            return
        yield waiting


def given_parameters(node: Node) -> dict[str, Any]:
    """Return the parameters given on the command line and in files: name to value."""
    return {name: parameter.value for name, parameter in node._parameter_overrides.items()}

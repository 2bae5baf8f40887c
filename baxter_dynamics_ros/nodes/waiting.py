"""Waiting in asynchronous callbacks, and their refusals."""

from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future

from ..model.exceptions import BaxterDynamicsError


class RefusedError(BaxterDynamicsError):
    """A request that cannot be carried out, with the reason."""


async def pause(node: Node, group: CallbackGroup, seconds: float) -> None:
    """
    Let other callbacks run for some time [s].

    The group must be reentrant: a group that is mutually exclusive blocks its other callbacks
    while one of them waits.
    """
    future = Future()
    timer = node.create_timer(seconds, lambda: future.done() or future.set_result(None),
                              callback_group=group, clock=Clock(clock_type=ClockType.STEADY_TIME))
    try:
        await future
    finally:
        node.destroy_timer(timer)

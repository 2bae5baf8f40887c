"""Periodic diagnostics of a node; diagnostic_updater is not available as a wheel."""

from collections.abc import Callable
import time

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from . import topics

OK = DiagnosticStatus.OK
WARN = DiagnosticStatus.WARN
ERROR = DiagnosticStatus.ERROR
STALE = DiagnosticStatus.STALE

_PERIOD = 1.0  # [s]


def first_case(values: dict[str, object], *cases: tuple[object, bytes, str]) -> DiagnosticStatus:
    """Return a status with level and message of the first case whose condition holds."""
    level, message = next((level, message) for holds, level, message in cases if holds)
    return DiagnosticStatus(level=level, message=message, values=[
        KeyValue(key=key, value=str(value)) for key, value in values.items()])


class DiagnosticUpdater:
    """
    Publishes diagnostics once a second, and logs each change of a status.

    ``report`` returns the statuses by name, given the time since the last report [s]. The timer
    uses steady time, so diagnostics continue while simulated time stands still.
    """

    def __init__(self, node: Node, hardware_id: str,
                 report: Callable[[float], dict[str, DiagnosticStatus]]) -> None:
        self._node = node
        self._hardware_id = hardware_id
        self._report = report
        self._reported_at = time.monotonic()
        self._logged: dict[str, DiagnosticStatus] = {}  # by status name
        self._publisher = node.create_publisher(
            DiagnosticArray, topics.DIAGNOSTICS, topics.PUBLISHER_QOS)
        node.create_timer(_PERIOD, self._update, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _update(self) -> None:
        now = time.monotonic()
        period, self._reported_at = now - self._reported_at, now
        prefix = self._node.get_fully_qualified_name().lstrip('/')
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        for name, status in self._report(period).items():
            status.name, status.hardware_id = f'{prefix}: {name}', self._hardware_id
            message.status.append(status)
            self._log(name, status)
        self._publisher.publish(message)

    def _log(self, name: str, status: DiagnosticStatus) -> None:
        """Log a changed status, unless it is only the consequence of missing input."""
        before = self._logged.get(name, DiagnosticStatus())
        if status.level == STALE and name != 'input' or (
                before.level, before.message) == (status.level, status.message):
            return
        if status.level != OK:
            self._node.get_logger().warning(f'{name}: {status.message}')
        elif before.level != OK:
            self._node.get_logger().info(f'{name}: {status.message}')
        self._logged[name] = status

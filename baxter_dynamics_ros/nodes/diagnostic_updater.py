"""Periodic diagnostics of a node; diagnostic_updater is not available as a wheel."""

from collections.abc import Callable
from dataclasses import dataclass, field
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


@dataclass
class Status:
    """One diagnostic status."""

    level: bytes
    message: str
    values: dict[str, object] = field(default_factory=dict)


def first_case(values: dict[str, object], *cases: tuple[object, bytes, str]) -> Status:
    """Return a status with level and message of the first case whose condition holds."""
    return next(Status(level, message, values) for holds, level, message in cases if holds)


class DiagnosticUpdater:
    """
    Publishes diagnostics once a second, and logs each change of a status.

    ``report`` returns the statuses by name, given the time since the last report [s]. The timer
    uses steady time, so diagnostics continue while simulated time stands still.
    """

    def __init__(self, node: Node, hardware_id: str,
                 report: Callable[[float], dict[str, Status]]) -> None:
        self._node = node
        self._hardware_id = hardware_id
        self._report = report
        self._reported_at = time.monotonic()
        self._logged: dict[str, Status] = {}  # by status name
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
            message.status.append(DiagnosticStatus(
                level=status.level, name=f'{prefix}: {name}', message=status.message,
                hardware_id=self._hardware_id,
                values=[KeyValue(key=key, value=str(value))
                        for key, value in status.values.items()]))
            self._log(name, status)
        self._publisher.publish(message)

    def _log(self, name: str, status: Status) -> None:
        """Log a changed status, unless it is only the consequence of missing input."""
        before = self._logged.get(name, Status(OK, ''))
        if status.level == STALE and name != 'input' or (
                before.level, before.message) == (status.level, status.message):
            return
        if status.level != OK:
            self._node.get_logger().warning(f'{name}: {status.message}')
        elif before.level != OK:
            self._node.get_logger().info(f'{name}: {status.message}')
        self._logged[name] = status

"""Messages of a predictor, as received on its topics."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
import math
from typing import Any, NamedTuple

from ..model.joints import JOINTS, SIDES

STALE_AFTER = 1.0  # [s] without a message
DIAGNOSTICS_STALE_AFTER = 3.0  # [s]; they are published once a second
_RATE_WINDOW = 2.0  # [s]
_MAX_STATUSES = 12  # kept of a message

Values = dict[str, float]  # joint, such as 's0', to a value [N m]


class Topic:
    """Newest message of a topic, and the rate of messages."""

    def __init__(self) -> None:
        self._message: Any = None
        self._times: deque[float] = deque(maxlen=5000)  # of receipt, monotonic [s]

    def receive(self, message: Any, now: float) -> None:
        """Receive a message at monotonic time now [s]."""
        if self._times and now - self._times[-1] > STALE_AFTER:
            self._times.clear()
        self._message = message
        self._times.append(now)

    def newest(self, now: float) -> Any:
        """Return the newest message; None if it is older than a second."""
        return self._message if self._times and now - self._times[-1] <= STALE_AFTER else None

    def rate(self, now: float) -> float:
        """Return the rate over the last two seconds [Hz]."""
        while self._times and self._times[0] < now - _RATE_WINDOW:
            self._times.popleft()
        if len(self._times) < 2:
            return 0.0
        return (len(self._times) - 1) / (now - self._times[0])


class Instant(NamedTuple):
    """Efforts of one instant, joint to value [N m]."""

    measured: Values
    predicted: Values
    residual: Values


class Predictor:
    """Messages of one predictor, given by its name with namespace."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.predicted, self.residual, self.external = Topic(), Topic(), Topic()
        self.contact, self.joint_states = Topic(), Topic()  # joint states with its joints
        self._joint_names: tuple[str, ...] = ()
        self._predictions: deque[Any] = deque(maxlen=256)  # until their residual arrives
        self._statuses: Sequence[Any] = ()
        self._reported = -math.inf  # monotonic time of the diagnostics [s]
        self._contact_since = -math.inf  # [s]

    @property
    def side(self) -> str:
        """'right' or 'left', by the names of the joints; '' if unknown."""
        words = self._joint_names[0].split('_') if self._joint_names else ()
        return next((side for side in SIDES if side in words), '')

    def receive_prediction(self, message: Any, now: float) -> None:
        """Receive a predicted effort."""
        self._joint_names = tuple(message.name)
        self._predictions.append(message)
        self.predicted.receive(message, now)

    def receive_joint_state(self, message: Any, now: float) -> None:
        """Receive a joint state; ignore those of another arm."""
        if set(self._joint_names) <= set(message.name):
            self.joint_states.receive(message, now)

    def receive_contact(self, message: Any, now: float) -> None:
        """Receive whether the arm is in contact."""
        before = self.contact.newest(now)
        if message.data and not (before and before.data):
            self._contact_since = now
        self.contact.receive(message, now)

    def receive_diagnostics(self, message: Any, now: float) -> None:
        """Receive diagnostics; ignore those of another node."""
        prefix = self.name.lstrip('/') + ': '
        statuses = [status for status in message.status if status.name.startswith(prefix)]
        if statuses:
            self._statuses, self._reported = statuses[:_MAX_STATUSES], now

    def is_live(self, now: float) -> bool:
        """Return whether predictions or diagnostics arrive."""
        return self.predicted.newest(now) is not None or bool(self.diagnostics(now))

    def instant(self, now: float) -> Instant | None:
        """Return the efforts of the newest residual; None if there is no residual."""
        residual = self.residual.newest(now)
        for predicted in reversed(self._predictions):
            if residual is not None and predicted.header.stamp == residual.header.stamp:
                p, r = by_joint(predicted), by_joint(residual)
                return Instant({joint: p[joint] + r[joint] for joint in p.keys() & r.keys()}, p, r)
        return None

    def delay(self, now: float) -> float | None:
        """Return the delay of the residual to the joint states [s]; None if unknown."""
        measured, residual = self.joint_states.newest(now), self.residual.newest(now)
        if measured is None or residual is None:
            return None
        delay = _seconds(measured) - _seconds(residual)
        return delay if 0.0 <= delay < 10.0 else None  # otherwise the clocks differ

    def diagnostics(self, now: float) -> list[tuple[str, int, str]]:
        """Return name, level and message of each status; nothing if they are stale."""
        if now - self._reported > DIAGNOSTICS_STALE_AFTER:
            return []
        return [(status.name.partition(': ')[2], int.from_bytes(status.level, 'little'),
                 status.message) for status in self._statuses]

    def contact_joints(self) -> list[str]:
        """Return the joints that the newest diagnostics report in contact."""
        if self._reported < self._contact_since:
            return []
        named = ','.join(pair.value for status in self._statuses for pair in status.values
                         if pair.key == 'joints in contact')
        return [joint for joint in JOINTS if joint in named.replace(' ', '').split(',')]

    def contact_duration(self, now: float) -> float:
        """Return the duration of the contact [s]."""
        return now - self._contact_since


def by_joint(message: Any) -> Values:
    """Return the finite efforts of a joint state by the last part of the joint's name."""
    return {name.rpartition('_')[2]: effort for name, effort in zip(message.name, message.effort)
            if math.isfinite(effort)}


def _seconds(message: Any) -> float:
    stamp = message.header.stamp
    return float(stamp.sec + 1e-9 * stamp.nanosec)

"""Running predictors and their recent messages."""

from collections import deque
from collections.abc import Callable, Iterator
from functools import partial
import os
import time
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from .listener import Listener
from ..model.arrays import Array
from ..model.joints import JOINTS, N_JOINTS, SIDES
from ..nodes import topics
from ..nodes.messages import stamp_ns

STALE_AFTER = 1.0  # [s] without a message
_DIAGNOSTICS_STALE_AFTER = 3.0  # [s]; they are published once a second
_RATE_WINDOW = 2.0  # [s]
_DISCOVERY_PERIOD = 0.5  # [s]
_GRACE = 2.0  # [s] before a missing predictor is reported
_Receive = Callable[[Any, float], None]  # a message, at monotonic time [s]
_NOTHING = np.full(N_JOINTS, np.nan)


class Signal:
    """Messages of a topic in the last two seconds: stamp [ns] and value."""

    def __init__(self) -> None:
        self._rows: deque[tuple[float, int, Any]] = deque()  # with the time of receipt [s]

    def add(self, stamp: int, value: Any, now: float) -> None:
        """Add a message received at monotonic time now [s]."""
        self._rows.append((now, stamp, value))
        while self._rows[0][0] < now - _RATE_WINDOW:
            self._rows.popleft()

    def newest(self, now: float) -> tuple[int, Any] | None:
        """Return the newest stamp and value; None if they are older than a second."""
        is_fresh = self._rows and now - self._rows[-1][0] <= STALE_AFTER
        return self._rows[-1][1:] if is_fresh else None

    def at(self, stamp: int) -> Any:
        """Return the value with a stamp [ns]; None if there is none."""
        return next((value for _, each, value in reversed(self._rows) if each == stamp), None)

    def rate(self, now: float) -> float:
        """Return the rate over the last two seconds [Hz]."""
        times = [receipt for receipt, _, _ in self._rows if receipt >= now - _RATE_WINDOW]
        return (len(times) - 1) / (now - times[0]) if len(times) > 1 else 0.0


class Status(NamedTuple):
    """One status of the diagnostics."""

    name: str
    level: int
    message: str
    values: dict[str, str]


class Instant(NamedTuple):
    """Efforts of one instant, (7,) [N m]; NaN if unknown."""

    measured: Array
    predicted: Array
    residual: Array
    deviation: Array  # expected standard deviation of the residual, positive


class Predictor:
    """Recent messages of one predictor, by its name with namespace."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.side = ''  # 'right' or 'left', by the names of the joints; '' if unknown
        self.predicted, self.residual, self.deviation, self.external = (
            Signal() for _ in range(4))
        self.wrench, self.contact, self.joint_states = (Signal() for _ in range(3))
        self._statuses: list[Status] = []
        self._reported = self._contact_since = -np.inf  # monotonic [s]

    def receive_effort(self, signal: Signal, message: Any, now: float) -> None:
        """Receive an effort by the names of its joints."""
        values = {name.rpartition('_')[2]: effort
                  for name, effort in zip(message.name, message.effort)}
        effort = np.array([values.get(joint, np.nan) for joint in JOINTS])
        self.side = next((side for side in SIDES if message.name
                          and side in message.name[0].split('_')), '')
        signal.add(stamp_ns(message.header), effort, now)

    def receive_joint_state(self, message: Any, now: float) -> None:
        """Receive a joint state; ignore those of another arm."""
        if self.side and any(f'{self.side}_{JOINTS[0]}' in name for name in message.name):
            self.joint_states.add(stamp_ns(message.header), message, now)

    def receive_wrench(self, message: Any, now: float) -> None:
        """Receive an external wrench; its value is the force (3,) [N] and the frame."""
        force = message.wrench.force
        self.wrench.add(stamp_ns(message.header), (np.array([force.x, force.y, force.z]),
                                                   message.header.frame_id), now)

    def receive_contact(self, message: Any, now: float) -> None:
        """Receive whether the arm is in contact."""
        if message.data and not self.in_contact(now):
            self._contact_since = now
        self.contact.add(0, message.data, now)

    def receive_diagnostics(self, message: Any, now: float) -> None:
        """Receive diagnostics; ignore those of another node."""
        prefix = self.name.lstrip('/') + ': '
        statuses = [Status(status.name.removeprefix(prefix), ord(status.level), status.message,
                           {pair.key: pair.value for pair in status.values})
                    for status in message.status if status.name.startswith(prefix)]
        if statuses:
            self._statuses, self._reported = statuses, now

    def instant(self, now: float) -> Instant:
        """Return the efforts of the newest residual; without one, the newest prediction alone."""
        residual, newest = self.residual.newest(now), self.predicted.newest(now)
        predicted = None if residual is None else self.predicted.at(residual[0])
        if residual is None or predicted is None:
            return Instant(_NOTHING, newest[1] if newest else _NOTHING, _NOTHING, _NOTHING)
        deviation = self.deviation.at(residual[0])
        return Instant(predicted + residual[1], predicted, residual[1],
                       _NOTHING if deviation is None else np.where(deviation > 0.0, deviation,
                                                                   np.nan))

    def delay(self, now: float) -> float | None:
        """Return the delay of the residual to the joint states [s]; None if unknown."""
        measured, residual = self.joint_states.newest(now), self.residual.newest(now)
        if measured is None or residual is None:
            return None
        delay = (measured[0] - residual[0]) * 1e-9
        return delay if 0.0 <= delay < 10.0 else None  # otherwise the clocks differ

    def diagnostics(self, now: float) -> list[Status]:
        """Return the newest diagnostics; nothing if they are stale."""
        return self._statuses if now - self._reported <= _DIAGNOSTICS_STALE_AFTER else []

    def explanation(self, now: float) -> str:
        """Return the sentence of the diagnostics that explains the residual; may be empty."""
        return next(filter(None, (status.values.get('explanation')
                                  for status in self.diagnostics(now))), '')

    def in_contact(self, now: float) -> bool | None:
        """Return whether the arm is in contact; None if unknown."""
        newest = self.contact.newest(now)
        return None if newest is None else newest[1]

    def contact_joints(self, now: float) -> list[str]:
        """Return the joints in contact, as far as the diagnostics have reported them."""
        if not self.in_contact(now) or self._reported < self._contact_since:
            return []
        named = [joint for status in self._statuses
                 for joint in status.values.get('joints in contact', '').split(', ')]
        return [joint for joint in JOINTS if joint in named]

    def contact_duration(self, now: float) -> float:
        """Return the duration of the contact [s]."""
        return now - self._contact_since


class Monitor:
    """Predictors of a name, found while they run, also below right/ and left/."""

    def __init__(self, listener: Listener, name: str, joint_states: str,
                 side: str | None) -> None:
        self.name = '/' + name.strip('/')
        self.wait = listener.wait
        self._listener = listener
        self._topic, self._side = joint_states, side
        self._predictors: dict[str, Predictor] = {}
        self._others: set[str] = set()  # predictors of other names
        self._started = time.monotonic()
        self._discovered = -np.inf  # monotonic time of the last discovery [s]
        self._subscribe(JointState, joint_states, self._to_all(Predictor.receive_joint_state))
        self._subscribe(DiagnosticArray, topics.DIAGNOSTICS,
                        self._to_all(Predictor.receive_diagnostics))

    def ticks(self, period: float, duration: float,
              is_done: Callable[[], bool] = lambda: False) -> Iterator[float]:
        """Receive messages and yield the monotonic time [s] every period, until it is done."""
        end = time.monotonic() + duration
        while True:
            self._discover()
            yield (now := time.monotonic())
            if now >= end or self.wait(is_done, min(period, end - now)):
                return

    def shown(self, now: float) -> list[Predictor]:
        """Return the live predictors; all if none is live."""
        ours = [each for each in self._predictors.values()
                if self._side in (None, each.side) or not each.side]
        return [each for each in ours if each.predicted.newest(now) or each.diagnostics(now)
                ] or ours

    def problem(self, now: float, grace: float = _GRACE) -> str | None:
        """Return what is missing and the remedy; None if predictions arrive."""
        shown = self.shown(now)
        if any(each.predicted.newest(now) for each in shown):
            return None
        if now - self._started < grace:
            return f'waiting for {self.name}'
        if self._predictors and not shown:
            return f'{self.name} does not predict the {self._side} arm: see --arm and --node'
        if not shown:
            others = ', '.join(sorted(self._others))
            return (f'no predictor {self.name} in ROS domain '
                    f'{os.environ.get("ROS_DOMAIN_ID") or 0}: is torque_predictor running with '
                    'the same ROS_DOMAIN_ID?' + (f' Found {others} (--node).' if others else ''))
        reasons = [status.message for each in shown for status in each.diagnostics(now)
                   if status.level]
        return f'no predictions from {self.name}: ' + (
            reasons[0] if reasons else f'are joint states published on {self._topic}?')

    def _discover(self) -> None:
        """Subscribe to new predictors."""
        if time.monotonic() - self._discovered < _DISCOVERY_PERIOD:
            return
        self._discovered = time.monotonic()
        node, ending = self._listener.node, '/' + topics.PREDICTED_EFFORT
        namespace, _, name = self.name.rpartition('/')
        ours = {self.name, *(f'{namespace}/{side}/{name}' for side in SIDES)}
        running = {topic.removesuffix(ending) for topic, _ in node.get_topic_names_and_types()
                   if topic.endswith(ending) and node.count_publishers(topic)}
        self._others = running - ours
        for found in sorted(running & ours - self._predictors.keys()):
            self._predictors[found] = self._follow(Predictor(found))

    def _follow(self, predictor: Predictor) -> Predictor:
        for topic, signal in ((topics.PREDICTED_EFFORT, predictor.predicted),
                              (topics.EFFORT_RESIDUAL, predictor.residual),
                              (topics.RESIDUAL_DEVIATION, predictor.deviation),
                              (topics.EXTERNAL_EFFORT, predictor.external)):
            self._subscribe(JointState, f'{predictor.name}/{topic}',
                            partial(predictor.receive_effort, signal))
        self._subscribe(WrenchStamped, f'{predictor.name}/{topics.EXTERNAL_WRENCH}',
                        predictor.receive_wrench)
        self._subscribe(Bool, f'{predictor.name}/{topics.CONTACT}', predictor.receive_contact)
        return predictor

    def _to_all(self, receive: Callable[[Predictor, Any, float], None]) -> _Receive:
        def receive_all(message: Any, now: float) -> None:
            for predictor in self._predictors.values():
                receive(predictor, message, now)
        return receive_all

    def _subscribe(self, kind: type, topic: str, receive: _Receive) -> None:
        self._listener.subscribe(kind, topic,
                                 lambda message: receive(message, time.monotonic()))

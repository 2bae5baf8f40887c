"""Running predictors and their recent messages."""

from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Iterator
import math
import os
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from .listener import Listener
from ..model import Array, BAND, JOINTS, SIDES
from ..nodes import topics
from ..nodes.messages import stamp_ns

_STALE_AFTER = 1.0  # [s] without a message
_STATUS_STALE_AFTER = 3.0  # [s]; they are published once a second
_RATE_WINDOW = 2.0  # [s]
_BATCH = 1e-3  # longest time in which a batch of messages is received [s]
_DISCOVERY_PERIOD = 0.5  # [s]
_GRACE = 2.0  # [s] before a missing predictor is reported
# Topic below the predictor's name -> type.
_TOPICS = {topics.PREDICTED_EFFORT: JointState, topics.EFFORT_RESIDUAL: JointState,
           topics.RESIDUAL_DEVIATION: JointState, topics.EXTERNAL_EFFORT: JointState,
           topics.EXTERNAL_WRENCH: WrenchStamped, topics.CONTACT: Bool}
_RATES = {'predictions': topics.PREDICTED_EFFORT, 'residuals': topics.EFFORT_RESIDUAL,
          'joint states': topics.JOINT_STATES}


class MonitoredPredictor:
    """Recent messages of one predictor, by its name with namespace; times are monotonic [s]."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.side = ''  # 'right' or 'left', by the names of the joints; '' if unknown
        self.contact_since = -math.inf
        self._is_older = False  # whether contact may have begun before that
        self._recent: dict[str, deque[tuple[float, Any]]] = defaultdict(deque)  # by topic

    def receive(self, topic: str, message: Any, now: float) -> None:
        """Receive a message; ignore those of other arms and nodes."""
        if topic == topics.DIAGNOSTICS:
            message = [status for status in message.status
                       if status.name.startswith(self.name.lstrip('/') + ': ')]
            if not message:
                return
        elif topic == topics.PREDICTED_EFFORT:
            self.side = next((side for side in SIDES if message.name
                              and side in message.name[0].split('_')), '')
        elif topic == topics.CONTACT and message.data and not (known := self.in_contact(now)):
            self.contact_since, self._is_older = now, known is None
        elif topic == topics.JOINT_STATES and not any(
                f'{self.side}_{JOINTS[0]}' in name for name in message.name):
            return
        recent = self._recent[topic]
        recent.append((now, message))
        while recent[0][0] < now - _RATE_WINDOW:
            recent.popleft()

    def newest(self, topic: str, now: float) -> Any:
        """Return the newest message of a topic; None if it is stale."""
        limit = _STATUS_STALE_AFTER if topic == topics.DIAGNOSTICS else _STALE_AFTER
        recent = self._recent[topic]
        return recent[-1][1] if recent and now - recent[-1][0] <= limit else None

    def rates(self, now: float) -> str:
        """Return the rates of the topics, and the delay of the residual to the joint states."""
        rates = [f'{name} {self._rate(topic, now):.1f} Hz' for name, topic in _RATES.items()]
        measured, residual = (self.newest(topic, now)
                              for topic in (topics.JOINT_STATES, topics.EFFORT_RESIDUAL))
        if measured is not None and residual is not None:
            delay = (stamp_ns(measured.header) - stamp_ns(residual.header)) * 1e-9
            if 0.0 <= delay < 10.0:  # otherwise the clocks differ
                rates.append(f'delay {1e3 * delay:.0f} ms')
        return ', '.join(rates)

    def _rate(self, topic: str, now: float) -> float:
        times = [receipt for receipt, _ in self._recent[topic] if receipt >= now - _RATE_WINDOW]
        later = sum(receipt > times[0] + _BATCH for receipt in times)
        return later / (now - times[0]) if later else 0.0

    def efforts(self, now: float) -> Array:
        """
        Return measured, predicted, residual and its expected range, (4, 7) [N m].

        All are of the newest residual; without one, the newest prediction is alone among NaN.
        """
        residual = self.newest(topics.EFFORT_RESIDUAL, now)
        predicted, deviation = (
            next((message for _, message in reversed(self._recent[topic])
                  if residual and message.header.stamp == residual.header.stamp), None)
            for topic in (topics.PREDICTED_EFFORT, topics.RESIDUAL_DEVIATION))
        if predicted is None:
            residual = deviation = None
            predicted = self.newest(topics.PREDICTED_EFFORT, now)
        p, r, d = map(effort_by_joint, (predicted, residual, deviation))
        return np.array([p + r, p, r, BAND * np.where(d > 0.0, d, np.nan)])

    def residual(self, now: float) -> str:
        """Return which residuals lie beyond their expected range; empty if that is unknown."""
        _, _, residual, band = self.efforts(now)
        beyond = [joint for joint, x, limit in zip(JOINTS, residual, band) if abs(x) > limit]
        if beyond:
            return 'residual beyond its expected range at ' + ', '.join(beyond)
        return '' if np.isnan(band).all() else 'all residuals are within their expected range'

    def diagnostics(self, now: float) -> list[tuple[str, int, str]]:
        """Return name, level and message of the newest statuses; nothing if they are stale."""
        return [(status.name.partition(': ')[2], min(ord(status.level), 3), status.message)
                for status in self.newest(topics.DIAGNOSTICS, now) or ()]

    def explanation(self, now: float) -> str:
        """Return the sentence of the diagnostics that explains the residual; may be empty."""
        return self._value('explanation', now)

    def in_contact(self, now: float) -> bool | None:
        """Return whether the arm is in contact; None if unknown."""
        newest = self.newest(topics.CONTACT, now)
        return None if newest is None else newest.data

    def contact(self, now: float) -> str:
        """Return the state of contact: joints and duration."""
        in_contact = self.in_contact(now)
        if not in_contact:
            return 'contact unknown' if in_contact is None else 'no contact'
        joints = ', '.join(self.contact_joints(now)) or 'joints not yet known'
        return f'CONTACT for {"over " * self._is_older}{now - self.contact_since:.1f} s: {joints}'

    def contact_joints(self, now: float) -> list[str]:
        """Return the joints in contact, as far as the diagnostics have reported them."""
        recent = self._recent[topics.DIAGNOSTICS]
        if not self.in_contact(now) or not recent or recent[-1][0] < self.contact_since:
            return []
        named = self._value('joints in contact', now).split(', ')
        return [joint for joint in JOINTS if joint in named]

    def _value(self, key: str, now: float) -> str:
        return next((pair.value for status in self.newest(topics.DIAGNOSTICS, now) or ()
                     for pair in status.values if pair.key == key and pair.value), '')


def effort_by_joint(message: JointState | None) -> Array:
    """Return the effort of a message by the names of its joints (7,) [N m]; NaN if unknown."""
    values = {} if message is None else {
        name.rpartition('_')[2]: effort for name, effort in zip(message.name, message.effort)}
    return np.array([values.get(joint, np.nan) for joint in JOINTS])


class Monitor:
    """Predictors of a name, found while they run, also below right/ and left/."""

    def __init__(self, listener: Listener, name: str, topic: str, side: str | None) -> None:
        self._listener, self._name = listener, '/' + name.strip('/')
        self._topic, self._side = topic, side  # of the joint states
        self._predictors: dict[str, MonitoredPredictor] = {}
        self._others: set[str] = set()  # predictors of other names
        self._started = time.monotonic()
        self._discovered = -math.inf  # monotonic time of the last discovery [s]
        everyone = self._predictors.values()  # also those found later
        self._subscribe(JointState, topic, topics.JOINT_STATES, everyone)
        self._subscribe(DiagnosticArray, topics.DIAGNOSTICS, topics.DIAGNOSTICS, everyone)

    def ticks(self, period: float, duration: float,
              is_done: Callable[[], bool] = lambda: False) -> Iterator[float]:
        """Receive messages and yield the monotonic time [s] every period, until it is done."""
        end = time.monotonic() + duration
        while True:
            self._discover()
            yield (now := time.monotonic())
            if now >= end or self._listener.wait(is_done, min(period, end - now)):
                return

    def shown(self, now: float) -> list[MonitoredPredictor]:
        """Return the live predictors; all if none is live."""
        ours = [each for each in self._predictors.values()
                if self._side in (None, each.side) or not each.side]
        return [each for each in ours if each.newest(topics.PREDICTED_EFFORT, now)
                or each.diagnostics(now)] or ours

    def problem(self, now: float, grace: float = _GRACE) -> str | None:
        """Return the reason why no predictions arrive, with a remedy; None if they arrive."""
        shown = self.shown(now)
        if any(each.newest(topics.PREDICTED_EFFORT, now) for each in shown):
            return None
        if now - self._started < grace:
            return f'waiting for {self._name}'
        if self._predictors and not shown:
            return f'{self._name} does not predict the {self._side} arm: see --arm and --node'
        if not shown:
            others = ', '.join(sorted(self._others))
            return (f'no predictor {self._name} in ROS domain '
                    f'{os.environ.get("ROS_DOMAIN_ID") or 0}: is torque_predictor running with '
                    'the same ROS_DOMAIN_ID?' + (f' Found {others} (--node).' if others else ''))
        reasons = [text for each in shown for _, level, text in each.diagnostics(now) if level]
        return f'no predictions from {self._name}: ' + (
            reasons[0] if reasons else f'are joint states published on {self._topic}?')

    def _discover(self) -> None:
        if time.monotonic() - self._discovered < _DISCOVERY_PERIOD:
            return
        self._discovered = time.monotonic()
        namespace, _, name = self._name.rpartition('/')
        ours = {self._name, *(f'{namespace}/{side}/{name}' for side in SIDES)}
        running = self._listener.predictors()
        self._others = running - ours
        for found in sorted(running & ours - self._predictors.keys()):
            predictor = self._predictors[found] = MonitoredPredictor(found)
            for topic, kind in _TOPICS.items():
                self._subscribe(kind, f'{found}/{topic}', topic, [predictor])

    def _subscribe(self, kind: type, name: str, topic: str,
                   predictors: Iterable[MonitoredPredictor]) -> None:
        """Let predictors receive the messages of a topic, by its name in ROS."""
        def receive(message: Any) -> None:
            for each in predictors:
                each.receive(topic, message, time.monotonic())
        self._listener.subscribe(kind, name, receive)

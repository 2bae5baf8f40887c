"""What a watcher has heard of a predictor: the newest values, their age, rates and a trace."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
import math

import numpy as np

from ..model.arrays import Array
from ..model.joints import joint_names, JOINTS, N_JOINTS, SIDES

Values = Sequence[float] | Array

STALE_AFTER = 1.0  # [s] without a message; what was heard last is then shown as old
STATUS_STALE_AFTER = 3.0  # [s]; diagnostics come once a second
BIN = 0.5  # [s] of a trace that make one extreme
_BINS = 120  # that are kept: a minute
_RATE_OVER = 2.0  # [s]
_MATCHED = 256  # predictions that are kept until the residual of their instant is heard


class Series:
    """The newest values of one topic, when they came, and how many come a second."""

    def __init__(self) -> None:
        self.values: Array | None = None  # (7,) [N m]
        self.stamp_ns = 0
        self.heard = -math.inf  # monotonic time [s]
        self._counts: deque[tuple[float, int]] = deque()  # when, how many at once

    def take(self, values: Array | None, stamp_ns: int, now: float) -> None:
        """Take a message that came at monotonic time now [s]."""
        self.values, self.stamp_ns = values, stamp_ns
        if now - self.heard > STALE_AFTER:
            self._counts.clear()
        self.heard = now
        waiting = self._counts.pop()[1] if self._counts and self._counts[-1][0] == now else 0
        self._counts.append((now, waiting + 1))
        self._forget(now)

    def age(self, now: float) -> float:
        """Return the time since the newest message [s]; infinite if there was none."""
        return now - self.heard

    def is_live(self, now: float) -> bool:
        """Return whether what was heard last is still worth showing as such."""
        return self.age(now) <= STALE_AFTER

    def rate(self, now: float) -> float:
        """Return how many messages came a second, over the last two [1/s]."""
        self._forget(now)
        if not self._counts or now <= self._counts[0][0]:
            return 0.0
        # Those that came first had been coming since nobody knows when, so they only begin it.
        counted = sum(count for _, count in self._counts) - self._counts[0][1]
        return counted / (now - self._counts[0][0])

    def _forget(self, now: float) -> None:
        """Drop what is too old to tell a rate by, but for one that begins it."""
        while len(self._counts) > 1 and self._counts[1][0] <= now - _RATE_OVER:
            self._counts.popleft()


class Trace:
    """The extremes of seven values in each of the last bins of time."""

    def __init__(self) -> None:
        self._bins: deque[tuple[int, Array]] = deque(maxlen=_BINS)

    def add(self, values: Array, now: float) -> None:
        """Add values (7,) of monotonic time now [s]."""
        number = math.floor(now / BIN)
        if not self._bins or self._bins[-1][0] != number:
            self._bins.append((number, values.copy()))
            return
        extreme = self._bins[-1][1]
        np.copyto(extreme, values, where=np.abs(values) > np.abs(extreme))

    def extremes(self, n: int, now: float) -> Array:
        """Return the values of greatest size in the last n bins (n, 7); NaN where none came."""
        result = np.full((n, N_JOINTS), np.nan)
        last = math.floor(now / BIN)
        for number, extreme in self._bins:
            if 0 <= (k := number - last + n - 1) < n:
                result[k] = extreme
        return result


@dataclass
class Status:
    """A diagnostic status: level 0 OK, 1 WARN, 2 ERROR, 3 STALE."""

    level: int
    message: str
    values: Mapping[str, str]
    heard: float  # monotonic time [s]


@dataclass
class ArmData:
    """What was heard of one arm of the predictor."""

    side: str = ''
    predicted: Series = field(default_factory=Series)
    residual: Series = field(default_factory=Series)
    external: Series = field(default_factory=Series)
    trace: Trace = field(default_factory=Trace)
    statuses: dict[str, Status] = field(default_factory=dict)
    contact: bool | None = None
    contact_heard: float = -math.inf
    contact_since: float = -math.inf  # when it was first heard
    saw_it_begin: bool = False
    _recent: deque[tuple[int, Array]] = field(default_factory=lambda: deque(maxlen=_MATCHED))

    def take_effort(self, topic: Series, effort: Array, stamp_ns: int, now: float) -> None:
        """Take efforts (7,) [N m] of a topic, which is one of the three above."""
        topic.take(effort, stamp_ns, now)
        if topic is self.predicted:
            self._recent.append((stamp_ns, effort))
        elif topic is self.residual:
            self.trace.add(effort, now)

    def take_contact(self, contact: bool, now: float) -> None:
        """Take whether something touches the arm."""
        if contact and not (self.contact and self.contact_is_live(now)):
            self.contact_since = now
            self.saw_it_begin = self.contact is False and self.contact_is_live(now)
        self.contact, self.contact_heard = contact, now

    def contact_is_live(self, now: float) -> bool:
        """Return whether it is known what touches the arm now."""
        return now - self.contact_heard <= STALE_AFTER

    def heard(self) -> float:
        """Return the monotonic time of the newest message about this arm [s]."""
        return max(self.predicted.heard, self.external.heard, self.contact_heard,
                   *(status.heard for status in self.statuses.values()), -math.inf)

    def instant(self) -> tuple[Array, Array, Array] | None:
        """
        Return measured, predicted and residual effort, each (7,) [N m], of one instant.

        None where no residual is heard whose prediction is heard, too.
        """
        if self.residual.values is None:
            return None
        for stamp_ns, predicted in reversed(self._recent):
            if stamp_ns == self.residual.stamp_ns:
                return predicted + self.residual.values, predicted, self.residual.values
        return None

    def joints_in_contact(self) -> tuple[str, ...]:
        """Return the joints that show the contact, as far as they are known."""
        status = self.statuses.get('external')
        if status is None:
            return ()
        if status.heard >= self.contact_since:  # the node itself has named them since
            named = status.values.get('joints in contact', '')
            if joints := tuple(joint for joint in JOINTS if joint in named.split(', ')):
                return joints
        return self._beyond_their_thresholds(status.values)

    def _beyond_their_thresholds(self, learnt: Mapping[str, str]) -> tuple[str, ...]:
        if self.external.values is None:
            return ()
        bias, threshold = (
            np.array([_number(learnt.get(f'{joint} {what} [N m]')) for joint in JOINTS])
            for what in ('bias', 'threshold'))
        beyond = np.abs(self.external.values - bias) > threshold  # never so where one is NaN
        return tuple(joint for joint, is_one in zip(JOINTS, beyond) if is_one)


class Watched:
    """
    What was heard of a predictor and its joint states, whatever the order of the joints.

    Attributes
    ----------
    inputs : dict
        Side to the measured efforts on the topic of the joint states; None for those that are
        empty or exactly zero, which are no measurement.
    arms : dict
        Side, or '' for a predictor's only arm, to what was heard of it.

    """

    def __init__(self) -> None:
        self.inputs = {side: Series() for side in SIDES}
        self.arms = {place: ArmData(place) for place in ('', *SIDES)}
        self._places: dict[tuple[tuple[str, ...], str], list[int] | None] = {}

    def take_joint_state(self, names: Sequence[str], effort: Values, stamp_ns: int,
                         now: float) -> None:
        """Take a joint state of the robot; its effort may be empty."""
        for side in SIDES:
            places = self._where(names, side)
            if places is not None:
                values = (np.array([effort[k] for k in places])
                          if len(effort) == len(names) else None)
                if values is not None and not values.any():
                    values = None
                self.inputs[side].take(values, stamp_ns, now)

    def take_effort(self, place: str, topic: str, names: Sequence[str], effort: Values,
                    stamp_ns: int, now: float) -> None:
        """Take efforts of the predictor; topic is 'predicted', 'residual' or 'external'."""
        for side in SIDES:
            places = self._where(names, side)
            if places is not None and len(effort) == len(names):
                arm = self._arm(place, side)
                values = np.array([effort[k] for k in places])
                values[~np.isfinite(values)] = np.nan  # which is drawn as nothing
                arm.take_effort(getattr(arm, topic), values, stamp_ns, now)

    def take_contact(self, place: str, contact: bool, now: float) -> None:
        """Take whether something touches the arm."""
        self.arms[place].take_contact(contact, now)

    def take_status(self, place: str, name: str, status: Status, hardware_id: str = '') -> None:
        """Take a diagnostic status; a side is read from its hardware id where there is one."""
        side = next((side for side in SIDES if f'_{side}_' in hardware_id), '')
        arm = self._arm(place, side) if side else self.arms[place]
        arm.statuses[name] = status

    def shown(self, side: str | None = None) -> list[ArmData]:
        """Return the arms of which anything was heard, or only that of a side."""
        heard = {place: arm for place, arm in self.arms.items() if arm.heard() > -math.inf}
        newest = max(heard, key=lambda place: heard[place].heard(), default='')
        # A predictor that starts again with other arms leaves none of the old ones behind.
        return [arm for place, arm in heard.items()
                if (place == '') == (newest == '') and side in (None, arm.side)]

    def _arm(self, place: str, side: str) -> ArmData:
        if self.arms[place].side != side:  # another arm from here on
            self.arms[place] = ArmData(side)
        return self.arms[place]

    def _where(self, names: Sequence[str], side: str) -> list[int] | None:
        """Return where the arm's joints are among names; None where one is not."""
        key = tuple(names), side
        if key not in self._places:
            if len(self._places) > 100:  # somebody makes names up
                self._places.clear()
            self._places[key] = _indices(names, joint_names(side))
        return self._places[key]


def _indices(names: Sequence[str], wanted: Iterable[str]) -> list[int] | None:
    where = {name: k for k, name in enumerate(names)}
    places = [where.get(name) for name in wanted]
    return None if None in places else [k for k in places if k is not None]


def _number(text: str | None) -> float:
    try:
        return float(text) if text is not None else math.nan
    except ValueError:
        return math.nan

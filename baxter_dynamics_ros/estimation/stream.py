"""Stream of one arm's joint states: selected by name, placed on one time line, counted."""

from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .continuity import Continuity, UNKNOWN_PERIOD, VelocityCheck
from .events import DROPPED, Event
from .retiming import Retiming, SHORT_STEP
from ..model import Array, Indices, joint_names, N_JOINTS

# Largest plausible values; a Baxter's limits are 3.1 rad, 4 rad/s and 50 N m.
PLAUSIBLE_POSITION = 2 * np.pi  # [rad]
PLAUSIBLE_VELOCITY = 40.0  # [rad/s]
PLAUSIBLE_EFFORT = 1000.0  # [N m]

_BOUNDS = np.array([[PLAUSIBLE_POSITION], [PLAUSIBLE_VELOCITY], [PLAUSIBLE_EFFORT]]).repeat(
    N_JOINTS, axis=1)
_MEMORY = 64  # message layouts remembered


class JointSelector:
    """Selects the joints of one arm, 'right' or 'left', whose names have a prefix."""

    def __init__(self, side: str, prefix: str = '') -> None:
        self.side = side
        self.names = tuple(prefix + name for name in joint_names(side))  # in the messages
        # Of the newest message without a full set of the arm's joints; None if there was none.
        self.other_names: tuple[str, ...] | None = None
        self._find_once = lru_cache(_MEMORY)(self._find)

    def layout(self, names: Sequence[str]) -> Indices | Event:
        """Return the indices (7,) of the arm's joints in ``names``, or why there are none."""
        return self._find_once(tuple(names))

    def _find(self, names: tuple[str, ...]) -> Indices | Event:
        present = [name for name in names if name in self.names]
        if not present:
            return Event.NOT_THIS_ARM
        if len(set(present)) < len(present):
            return Event.DUPLICATE_JOINT
        if len(present) < N_JOINTS:
            return Event.INCOMPLETE_ARM
        return np.array([names.index(name) for name in self.names])

    def read(self, names: Sequence[str], position: Array, velocity: Array,
             effort: Array) -> tuple[Array, Array | None, Array | None] | Event:
        """
        Return position, velocity and effort, read-only (7,), or why they cannot be used.

        The arrays are as long as names; velocity and effort may be empty. NaN means "not
        available": a velocity or effort that is empty or contains NaN is returned as None. Values
        of other joints are ignored.
        """
        layout = self.layout(names)
        if isinstance(layout, Event):
            self.other_names = tuple(names)
            return layout
        n = len(names)
        if len(position) != n or len(velocity) not in (0, n) or len(effort) not in (0, n):
            return Event.LENGTH_MISMATCH
        sample = np.zeros((3, N_JOINTS))
        sample[0] = position[layout]
        has_velocity, has_effort = len(velocity) > 0, len(effort) > 0
        if has_velocity:
            sample[1] = velocity[layout]
        if has_effort:
            sample[2] = effort[layout]
        if np.count_nonzero(np.abs(sample) <= _BOUNDS) < sample.size:  # false for NaN
            if np.isnan(sample[0]).any() or np.isinf(sample).any():
                return Event.NON_FINITE
            if (np.abs(sample) > _BOUNDS)[~np.isnan(sample).any(axis=1)].any():
                return Event.IMPLAUSIBLE
            has_velocity &= not np.isnan(sample[1]).any()
            has_effort &= not np.isnan(sample[2]).any()
        sample.setflags(write=False)
        return (sample[0], sample[1] if has_velocity else None, sample[2] if has_effort else None)


class State(NamedTuple):
    """The arm's state as last measured; arrays (7,) in joint order."""

    stamp_ns: int  # header stamp, or re-timed stamp [ns]
    q: Array  # [rad]
    qd: 'Array | None'  # [rad/s]; None if missing or contradicted by the positions
    effort: 'Array | None'  # [N m]; None if missing or invalid
    measured_qd: 'Array | None'  # [rad/s], whether or not the positions contradict it
    # Time since the last sample [s], 0 for the first; None while the period is not known.
    dt: 'float | None' = None
    begins: bool = True  # whether the stream starts with this sample


class Stream:
    """
    Validates joint states and extracts one arm's samples.

    ``counts`` holds the number of occurrences of each :class:`Event`, of all messages
    ('received'), and of those that were not dropped ('taken').
    """

    def __init__(self, side: str, stamps: str, prefix: str = '') -> None:
        self.selector = JointSelector(side, prefix)
        self.counts: Counter[Event | str] = Counter()
        self._begin(stamps)

    def _begin(self, stamps: str) -> None:
        self.clock = Retiming(stamps)
        self.velocity_check = VelocityCheck()
        self._continuity = Continuity()
        self._last_ns: int | None = None  # time of the last sample; None before the first

    def reset(self, stamps: str | None = None) -> None:
        """Forget the stream but not the counts; change the source of stamps if given."""
        self.counts[Event.RESET_REQUESTED] += 1
        self._begin(stamps or self.clock.mode)

    def take(self, stamp_ns: int, names: Sequence[str], position: Array, velocity: Array,
             effort: Array, received_ns: 'int | None' = None) -> 'State | Event':
        """
        Process a joint state; for the arguments see :meth:`.predictor.Predictor.handle`.

        Returns the reason if the message is dropped.
        """
        counts, clock = self.counts, self.clock
        counts['received'] += 1
        reading = self.selector.read(names, position, velocity, effort)
        if isinstance(reading, Event):
            counts[reading] += 1
            return reading
        q, qd, measured = reading
        stamp = clock.select(stamp_ns, received_ns)
        period = clock.period or (UNKNOWN_PERIOD if clock.retimed else None)
        verdict = self._continuity.judge(stamp, q, qd, measured, period)
        if verdict is not None and verdict is not Event.REPEATED_STAMP:
            counts[verdict] += 1
            if verdict in DROPPED:
                return verdict
            self._last_ns = None
        counts['taken'] += 1
        if stamp_ns == 0 and received_ns is not None:
            counts[Event.UNSTAMPED] += 1
        if qd is None:
            counts[Event.VELOCITY_MISSING] += 1
        usable_effort = self._usable_effort(measured)
        # The step to another publisher's message is no evidence about the robot's stamps.
        fresh = not self._continuity.repeated and verdict is not Event.RESET_POSITION_JUMP
        time_ns = self._time(stamp_ns, stamp, fresh, received_ns)
        if time_ns is None:
            counts[Event.AWAITING_PERIOD] += 1
            self._last_ns = None
            return State(stamp, q, qd, usable_effort, qd)
        dt, usable_qd = self._usable_velocity(self._step(time_ns, fresh), q, qd)
        begins, self._last_ns = self._last_ns is None, time_ns
        return State(time_ns, q, usable_qd, usable_effort, qd, dt, begins)

    def _time(self, stamp_ns: int, selected: int, fresh: bool, received_ns: int | None
              ) -> int | None:
        """Return a message's time on the stream's time line [ns]; None while unknown."""
        clock = self.clock
        time_ns = clock.update(stamp_ns, fresh, received_ns)
        if clock.event is not None:
            self.counts[clock.event] += 1
            self._last_ns = None
            if clock.select(stamp_ns, received_ns) != selected:
                self._continuity = Continuity()  # the next stamp is from another clock
        return time_ns

    def _step(self, time_ns: int, fresh: bool) -> float:
        """Return the time since the last sample [s]; zero for the first."""
        if self._last_ns is None:
            self.velocity_check.restart()
            return 0.0
        step = time_ns - self._last_ns
        if fresh and step < SHORT_STEP and not self.clock.retimed:
            self.counts[Event.REPEATED_STAMP] += 1
        return step * 1e-9

    def _usable_velocity(self, dt: float, q: Array, qd: Array | None
                         ) -> tuple[float, Array | None]:
        """Return velocity, or None if it is missing or contradicts the positions, after dt."""
        check = self.velocity_check
        if qd is None:
            check.restart()
            return dt, None
        before = check.usable
        usable = check.update(dt, q, qd)
        if check.mismatch is not None:
            self.counts[Event.POSITION_FROZEN if usable else Event.VELOCITY_MISMATCH] += 1
        if usable != before:
            self.counts[Event.RESET_VELOCITY_SOURCE] += 1
            self._last_ns, dt = None, 0.0
        return dt, qd if usable else None

    def _usable_effort(self, effort: Array | None) -> Array | None:
        """Return the measured effort, or None if it is missing or exactly zero on all joints."""
        if effort is None:
            self.counts[Event.EFFORT_MISSING] += 1
        elif not any(effort.tolist()):
            self.counts[Event.EFFORT_ALL_ZERO] += 1
            return None
        return effort

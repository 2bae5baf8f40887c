"""Continuity of a stream, and consistency of its velocity with its positions."""

from typing import NamedTuple

import numpy as np

from .events import DROPPED, Event
from ..model import Array, Bools, JOINTS, N_JOINTS, VELOCITY_LIMIT

GAP = 0.25  # longest time between two stamps before the filters restart [s]
CLOCK_JUMP = 0.5  # step between stamps that indicates another clock [s]
MAX_IN_A_ROW = 5  # consecutive messages dropped before the stream restarts with the next
# The robot publishes at 800 Hz or less, so closer stamps are times of arrival, and the samples may
# be up to UNKNOWN_PERIOD apart.
SHORTEST_PERIOD = 0.001  # [s]
UNKNOWN_PERIOD = 0.03  # [s]
# Largest position change that is never a jump [rad]; faster to compare with than a float.
_MARGIN = np.full(N_JOINTS, 0.02)
# Allowed difference between true and measured velocity. The published velocity spans 22 ms and
# lags by 14 ms; a wrist joint gains 4 rad/s in that time when the hand is hit with 200 N.
_UNMEASURED = 1.5 * VELOCITY_LIMIT  # [rad/s]
_STILL = np.zeros(N_JOINTS)  # [rad/s]
_TO_CONFIRM = (Event.RESET_CLOCK_JUMP, Event.RESET_POSITION_JUMP, Event.RESET_VELOCITY_SOURCE)
_CONTINUES = (None, Event.REPEATED_STAMP)

WINDOW = 1.0  # integration time of the velocity [s]
_CHECK_PERIOD = 0.5  # time between checks [s]; a late message looks like a mismatch if shorter
# Allowed difference between position and integrated velocity: velocity lags position by 14 ms on a
# Baxter, and stamps that are times of arrival add the transport delay.
_TOLERANCE = 0.03  # [rad]
_LAG = 0.02  # [s]; ... plus the change of velocity over this time, as in a hard push
_SHARE = 0.5  # ... plus this share of the motion
_EVIDENCE = 0.1  # motion needed to accept a velocity again [rad]


class _Sample(NamedTuple):
    """Arrays (7,) in joint order."""

    stamp_ns: int
    q: Array  # [rad]
    qd: Array | None  # [rad/s]
    effort: Array | None  # [N m]
    slope: Array  # measured velocity, or the slope of the positions if it is missing [rad/s]


class Continuity:
    """
    Compares each sample with the last accepted one.

    A position jump, a stamp 0.5 s or more from the last, and a velocity that appears or
    disappears restart the stream only once the next message confirms it. A single stray message,
    from another publisher for example, is dropped.
    """

    def __init__(self) -> None:
        # Whether the last sample repeats the data of the previous one less than 1 ms after it.
        self.repeated = False
        self._last: _Sample | None = None
        self._unconfirmed: _Sample | None = None
        self._dropped = 0  # consecutive out-of-order and unconfirmed messages

    def judge(self, stamp_ns: int, q: Array, qd: Array | None, effort: Array | None,
              period: float | None = None) -> 'Event | None':
        """
        Compare a sample with the stream, and remember it unless it is dropped.

        q [rad], qd [rad/s] and effort [N m] are (7,); ``period`` is the true period of the samples
        [s], where stamps are times of arrival. Returns a member of DROPPED: drop the sample;
        RESET_...: restart at it; REPEATED_STAMP: new data with the last stamp; None: it continues
        the stream or is the first one.
        """
        now = _Sample(stamp_ns, q, qd, effort, _STILL if qd is None else qd)
        event, last, self.repeated = None, self._last, False
        if last is not None:
            event = self._confirmed(self._compare(last, now, period), last, now, period)
            if event in DROPPED:
                return event
            if qd is None and event in _CONTINUES:
                dt = _since(last, now)
                now = now._replace(
                    slope=(q - last.q) / dt if dt >= SHORTEST_PERIOD else last.slope)
        self._last, self._unconfirmed, self._dropped = now, None, 0
        return event

    def _confirmed(self, event: Event | None, last: _Sample, now: _Sample,
                   period: float | None) -> Event | None:
        """Return the event, or the reason to drop a sample that is not confirmed yet."""
        if event is Event.OUT_OF_ORDER:
            self._dropped += 1
            return event if self._dropped < MAX_IN_A_ROW else Event.RESET_CLOCK_JUMP
        is_far = event is Event.RESET_GAP and _since(last, now) >= CLOCK_JUMP
        if not is_far and event not in _TO_CONFIRM:
            return event
        before, self._unconfirmed = self._unconfirmed, now
        if before is not None:
            repeats = self._compare(before, now, period)
            if repeats in (*_CONTINUES, Event.RESET_GAP):
                return event
            if repeats is Event.DUPLICATE:
                return repeats
        self._dropped += 1
        return Event.UNCONFIRMED if self._dropped < MAX_IN_A_ROW else event

    def _compare(self, last: _Sample, now: _Sample, period: float | None) -> Event | None:
        """Return how a sample departs from an earlier one; None if it continues it."""
        dt = _since(last, now)
        if dt > GAP:
            return Event.RESET_GAP
        if dt < 0.0:
            return Event.RESET_CLOCK_JUMP if -dt >= CLOCK_JUMP else Event.OUT_OF_ORDER
        if dt < SHORTEST_PERIOD:
            self.repeated = all(map(_same, now[1:4], last[1:4]))
            if dt == 0.0 and self.repeated:
                return Event.DUPLICATE
        if (now.qd is None) != (last.qd is None):
            return Event.RESET_VELOCITY_SOURCE
        moved = now.q - last.q
        if np.count_nonzero(np.abs(moved) > _MARGIN):  # otherwise never a jump
            if period is None and dt < SHORTEST_PERIOD:
                period = UNKNOWN_PERIOD
            if _jumps(moved, last.slope, now.slope, max(dt, period or 0.0)):
                return Event.RESET_POSITION_JUMP
        return Event.REPEATED_STAMP if dt == 0.0 else None


def _since(last: _Sample, now: _Sample) -> float:
    """Return the time between two samples [s]."""
    return (now.stamp_ns - last.stamp_ns) * 1e-9


def _jumps(moved: Array, before: Array, now: Array, dt: float) -> bool:
    """Return whether a change of position (7,) [rad] contradicts the velocities (7,) [rad/s]."""
    slowest, fastest = np.minimum(before, now), np.maximum(before, now)
    allowed = _MARGIN + dt * _UNMEASURED
    return bool(((moved > fastest * dt + allowed) | (moved < slowest * dt - allowed)).any())


def _same(a: Array | None, b: Array | None) -> bool:
    return a is b if a is None or b is None else bool((a == b).all())


class VelocityMismatch(NamedTuple):
    """Motion of a joint according to measured position and to measured velocity."""

    joint: str
    moved: float  # range of the position [rad]
    integrated: float  # range of the integral of the velocity [rad]
    duration: float  # [s]


class VelocityCheck:
    """Compares integrated velocity with the change of position over about a second."""

    def __init__(self) -> None:
        self.usable = True  # whether to use measured velocity; stays true with frozen positions
        # Largest of the last check that found one; None while velocity and position agree.
        self.mismatch: VelocityMismatch | None = None
        self._wrong: Bools = np.zeros(N_JOINTS, dtype=bool)
        # Position, integrated velocity, and their difference [rad]; velocity [rad/s].
        self._sample = np.zeros((4, N_JOINTS))
        self._begin_window()
        self.restart()

    def _begin_window(self) -> None:
        self._t, self._next_check = 0.0, _CHECK_PERIOD  # since the start of the window [s]
        self._low: Array = self._sample.copy()
        self._high: Array = self._sample.copy()

    def restart(self) -> None:
        """Start a new window, as after a gap."""
        self._last: Array | None = None  # velocity [rad/s]

    def update(self, dt: float, q: Array, qd: Array) -> bool:
        """Check q [rad] and qd [rad/s], (7,), dt [s] after the last; return whether to use qd."""
        sample, last, self._last = self._sample, self._last, qd
        integrated = 0.0 if last is None else sample[1] + (0.5 * dt) * (qd + last)
        sample[0], sample[1], sample[3] = q, integrated, qd
        np.subtract(sample[1], q, out=sample[2])
        if last is None:
            self._begin_window()
        else:
            self._t += dt
        np.minimum(self._low, sample, out=self._low)
        np.maximum(self._high, sample, out=self._high)
        if self._t >= self._next_check:
            self._next_check = self._t + _CHECK_PERIOD
            self._compare()
            if self._t >= WINDOW:
                self._begin_window()
        return self.usable

    def _compare(self) -> None:
        moved, integrated, difference, change = self._high - self._low
        motion = np.maximum(moved, integrated)
        excess = difference - _TOLERANCE - _LAG * change - _SHARE * motion  # [rad]
        differs = excess > 0.0
        is_complete = self._t >= WINDOW
        if is_complete:
            self._wrong &= differs | (motion < _EVIDENCE)
        self._wrong |= differs & (moved > 0.0)
        self.usable = not self._wrong.any()
        if differs.any():
            i = int(excess.argmax())
            self.mismatch = VelocityMismatch(
                JOINTS[i], float(moved[i]), float(integrated[i]), self._t)
        elif is_complete and self.usable:
            self.mismatch = None

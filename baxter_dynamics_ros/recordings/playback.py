"""
Playback of a recording; regularity of its stamps, lag of its velocity, contact.

A velocity that is ``lag`` seconds old integrates to less than the change of position by ``lag``
times the change of velocity: a straight line, fitted over intervals of one second, in which
noise and quantisation hardly matter. The slope of the change of position over the integrated
velocity is the scale: 1 if velocities are in rad/s and the stamps have the true period.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from .recording import RecordedState
from ..estimation.continuity import GAP
from ..estimation.motion_estimator import Estimate
from ..estimation.predictor import Predictor
from ..estimation.settings import ContactSettings
from ..model import Array, Bools, JOINTS, N_JOINTS
from ..model.joints import stops

BLOCK = 4096  # estimates in a batch
MOST_CONTACT = 0.2  # share of a recording above which a large residual is an error of the model
TRAVEL = 0.05  # range of position within which a joint counts as at rest [rad]

_NOTHING = np.full(N_JOINTS, np.nan)
_FEW = 20  # intervals below which nothing can be concluded
# Time between samples that ends a segment: a restarted filter settles for 0.21 s by default [s].
_BREAK = 0.15
_INTERVAL = 1.0  # of the integration of velocity [s]
_SLOPE = 0.02  # half the interval of the slope of position [s]
_SHORTEST = 0.1  # duration for which the residual must exceed its limit [s]
_RELEASE = 0.25  # contact lasts while the residual exceeds this share of its limit
_MARGIN = 0.2  # excluded before and after, for the memory of the filter [s]
_Samples = TypeVar('_Samples', bound='Samples')


@dataclass(frozen=True, eq=False)
class Samples:
    """Consecutive estimates of one arm, and measurements at those times; arrays (n, 7)."""

    time: Array  # (n,) since the first estimate; stamps that step back count as a gap [s]
    q: Array  # estimated position [rad]
    qd: Array  # estimated velocity [rad/s]
    qdd: Array  # estimated acceleration [rad/s^2]
    effort: Array  # measured effort in the band of qdd [N m]; NaN where none was measured
    dahl: Array  # Dahl's state [-]
    newest_q: Array  # newest position [rad]
    newest_qd: Array  # newest velocity as measured [rad/s]; NaN if missing
    usable_qd: Array  # the same; NaN also where the positions contradict it
    newest_effort: Array  # newest effort [N m]; NaN where none was measured
    dt: Array  # (n,) time since the previous measurement [s]
    first_difference: Array  # (newest - previous usable velocity) / dt [rad/s^2], or NaN

    @property
    def estimate(self) -> Estimate:
        """Return the estimates as a batch."""
        stamp_ns = np.rint(self.time * 1e9).astype(int)
        return Estimate(stamp_ns, self.q, self.qd, self.qdd, self.effort, self.dahl)

    def take(self: _Samples, rows: 'slice | Bools') -> _Samples:
        """Return some rows, a slice or (n,) bool."""
        return replace(self, **{name: value[rows] for name, value in vars(self).items()
                                if isinstance(value, np.ndarray)})


class StampStatistics(NamedTuple):
    """Regularity of stamps: the robot's own lie on a grid, times of arrival do not."""

    duration: float  # time covered, without gaps [s]
    rate: float  # stamps per second in that time [Hz]
    period: float = 0.0  # of the grid [s]; zero if there are too few stamps
    irregularity: float = 0.0  # RMS distance of an interval from the grid, share of the period
    lost: int = 0  # points of the grid without a stamp, gaps left out


class Lag(NamedTuple):
    """Lag of the velocity."""

    value: float  # [s]
    uncertainty: float  # standard error, from the differences between joints [s]
    per_joint: Array  # (7,) [s]; NaN for a joint that does not move


class Contact(NamedTuple):
    """One contact of one joint."""

    joint: str
    start: float  # since the beginning of the recording [s]
    end: float  # [s]
    peak: float  # largest residual [N m]
    at_stop: bool  # whether the joint is at the end of its range
    recording: str = ''

    def __str__(self) -> str:
        """Return joint, torque and time as text."""
        where = f'{self.joint} at its stop' if self.at_stop else self.joint
        return (f'{where}, {abs(self.peak):.0f} N m, from {self.start:.1f} to {self.end:.1f} s'
                + (f' of {self.recording}' if self.recording else ''))


def play(messages: Iterable[RecordedState], predictor: Predictor) -> Iterator[Samples]:
    """Pass joint states to a predictor; yield its estimates in blocks, the last one not full."""
    rows: list[Any] = []  # time [ns], estimate, newest and previous state
    previous: Any = None
    last_ns, time_ns = None, 0
    for message in messages:
        step = predictor.estimate(*message)
        if step.state is None:
            continue
        if step.estimate is not None and previous is not None:
            stamp_ns = step.estimate.stamp_ns
            passed = 0 if last_ns is None else stamp_ns - last_ns
            time_ns += passed if passed >= 0 else round(1e9 * GAP)
            last_ns = stamp_ns
            rows.append((time_ns, step.estimate, step.state, previous))
            if len(rows) == BLOCK:
                yield _stacked(rows)
                rows = []
        previous = step.state
    yield _stacked(rows)


def _stacked(rows: list[Any]) -> Samples:
    times, estimates, newest, previous = ([row[i] for row in rows] for i in range(4))
    dt = np.array([now.stamp_ns - then.stamp_ns for now, then in zip(newest, previous)]) * 1e-9
    usable_qd = _field(newest, 'qd')
    q, qd, qdd, effort, dahl = (_field(estimates, name) for name in Estimate._fields[1:])
    return Samples(
        np.array(times) * 1e-9, q, qd, qdd, effort, dahl, _field(newest, 'q'),
        _field(newest, 'measured_qd'), usable_qd, _field(newest, 'effort'), dt,
        (usable_qd - _field(previous, 'qd')) / dt[:, None])


def _field(of: list[Any], name: str) -> Array:
    """Return a field of estimates or states, (n, 7), with NaN for None."""
    values = (getattr(one, name) for one in of)
    return np.concatenate([np.empty(0), *(_NOTHING if value is None else value
                                          for value in values)]).reshape(-1, N_JOINTS)


def joined(parts: Iterable[Samples]) -> Samples:
    """Return consecutive samples as one."""
    return Samples(*map(np.concatenate, zip(*(vars(part).values() for part in parts))))


def stamp_statistics(dt: Array) -> StampStatistics:
    """Return the statistics of the times between measurements (n,) [s], however many are lost."""
    dt = dt[(dt > 0.0) & (dt <= GAP)]
    duration = float(dt.sum())
    rate = len(dt) / duration if duration else 0.0
    if len(dt) < _FEW:
        return StampStatistics(duration, rate)
    # If most messages are lost, the median is a multiple of the period.
    irregularity, period = min(_distance(dt, float(np.quantile(dt, share)))
                               for share in (0.5, 0.05))
    steps = np.maximum(np.rint(dt / period), 1.0)
    return StampStatistics(duration, rate, period, irregularity, int((steps - 1.0).sum()))


def _distance(dt: Array, period: float) -> tuple[float, float]:
    """Return the RMS distance of intervals from multiples of a period, in periods; and it."""
    steps = dt / period
    return float(np.sqrt(np.mean((steps - np.maximum(np.rint(steps), 1.0)) ** 2))), period


def segments(time: Array) -> list[slice]:
    """Return the slices between gaps of a time axis (n,) [s]."""
    breaks = np.flatnonzero(np.abs(np.diff(time)) > _BREAK) + 1
    return [slice(*pair) for pair in zip([0, *breaks], [*breaks, len(time)])]


def velocity_sums(samples: Samples) -> Array:
    """Return the sums for :func:`lag_and_scale`, (2, 2, 7), to be added to those of others."""
    return sum((_sums(samples.time[rows], samples.newest_q[rows], samples.newest_qd[rows])
                for rows in segments(samples.time)), start=np.zeros((2, 2, N_JOINTS)))


def _sums(t: Array, q: Array, qd: Array) -> Array:
    """Return sums (2, 2, 7) of x y and x^2 for the lines of lag and scale; 0 if too short."""
    period = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    if period <= 0.0 or len(t) * period < 3 * _INTERVAL or not np.isfinite(qd).all():
        return np.zeros((2, 2, N_JOINTS))
    n = max(round(_INTERVAL / period), 1)
    k = max(round(_SLOPE / period), 2)
    steps = 0.5 * np.diff(t)[:, None] * (qd[1:] + qd[:-1])
    integral = np.cumsum(np.concatenate([np.zeros((1, N_JOINTS)), steps]), axis=0)
    velocity = (q[2 * k:] - q[:-2 * k]) / (t[2 * k:] - t[:-2 * k])[:, None]
    moves = np.ptp(q, axis=0) > TRAVEL

    def change(values: Array) -> Array:
        """Return changes over the interval, less their mean; zero at rest."""
        changes = values[n:] - values[:-n]
        return (changes - changes.mean(0)) * moves

    lines = ((velocity, (q - integral)[k:-k]), (integral, q))  # x, y
    return np.array([np.sum([change(y) * change(x), change(x) ** 2], axis=1) for x, y in lines])


def lag_and_scale(sums: Array) -> tuple['Lag | None', float]:
    """Return the lag, and travel over integrated velocity; None and NaN if no joint moved."""
    products, squares = sums.swapaxes(0, 1)
    moves = squares > 1e-3 * squares.max(axis=1, keepdims=True)  # more than hardly
    if not moves.any(axis=1).all():  # also if joints move, but all velocities are zero
        return None, np.nan
    lags, scales = np.divide(products, squares, out=np.full_like(sums[0], np.nan), where=moves)
    known = lags[moves[0]]
    value = float(np.median(known))
    spread = float(np.std(known, ddof=1)) if len(known) > 1 else abs(value)
    return Lag(value, spread / float(np.sqrt(len(known))), lags), float(np.nanmedian(scales))


def find_contacts(time: Array, residual: Array, q: Array, recording: str = '') -> list[Contact]:
    """
    Return the contacts, by joint and time.

    Times are (n,) [s], positions and residuals (n, 7) [rad, N m]; a constant offset of the
    residual does not matter.
    """
    if not len(time):
        return []
    residual = residual - np.median(residual, axis=0)
    near_stop = stops(q) != 0.0
    return [Contact(JOINTS[i], float(time[rows][0]), float(time[rows][-1]),
                    float(max(residual[rows, i], key=abs)), bool(np.median(near_stop[rows, i])),
                    recording)
            for i, limit in enumerate(ContactSettings.limit) for part in segments(time)
            for rows in _intervals(time, residual[:, i], part, limit)]


def contact_rows(time: Array, contacts: list[Contact]) -> Bools:
    """Return whether each sample (n,) belongs to a contact or its margin."""
    mask = np.zeros(len(time), dtype=bool)
    for contact in contacts:
        mask |= (time > contact.start - _MARGIN) & (time < contact.end + _MARGIN)
    return mask


def _intervals(time: Array, signal: Array, part: slice, limit: float) -> list[slice]:
    """Return the intervals of a segment that exceed the limit for long enough."""
    size = np.abs(signal[part])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], size > _RELEASE * limit, [0]])))
    found = []
    for start, end in zip(edges[::2], edges[1::2]):
        beyond = time[part][start:end][size[start:end] > limit]
        if len(beyond) and beyond[-1] - beyond[0] >= _SHORTEST:
            found.append(slice(part.start + start, part.start + end))
    return found

"""Playback of a recording through the node's predictor in blocks; regularity of its stamps."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeVar

import numpy as np

from .recording import JointState
from ..estimation.continuity import GAP
from ..estimation.motion_estimator import Estimate
from ..estimation.predictor import Predictor
from ..estimation.stream import State
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS

BLOCK = 256  # estimates in a batch, few enough for the processor's cache

_NOTHING = np.full(N_JOINTS, np.nan)
_FEW = 20  # intervals below which nothing can be concluded
_Samples = TypeVar('_Samples', bound='Samples')


class Block(NamedTuple):
    """Consecutive estimates of one arm, and the newest measurements at those times."""

    estimate: Estimate  # arrays (n, 7); NaN where no effort was measured
    q: Array  # (n, 7) newest position [rad]
    qd: Array  # (n, 7) newest usable velocity [rad/s]; NaN where there is none
    measured_qd: Array  # (n, 7) newest velocity, even if the positions contradict it [rad/s]
    effort: Array  # (n, 7) newest effort [N m]; NaN where none was measured
    dt: Array  # (n,) time since the previous measurement [s]
    first_difference: Array  # (n, 7) (newest - previous velocity) / dt [rad/s^2], or NaN


@dataclass(frozen=True, eq=False)
class Samples:
    """Estimates of a recording that have a measured effort; arrays (n, 7) in joint order."""

    time: Array  # (n,) instants of the estimates [s]
    q: Array  # [rad]
    qd: Array  # [rad/s]
    qdd: Array  # [rad/s^2]
    effort: Array  # measured [N m]
    newest_q: Array  # newest position at the time of the estimate [rad]
    newest_qd: Array  # newest measured velocity [rad/s]; NaN if missing

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


def play(messages: Iterable[JointState], predictor: Predictor) -> Iterator[Block]:
    """Pass joint states to a predictor; yield blocks of up to BLOCK estimates, in order."""
    rows: list[tuple[Estimate, State, State]] = []
    previous = None
    for message in messages:
        step = predictor.estimate(*message)
        if step.state is None:
            continue
        if step.estimate is not None and previous is not None:
            rows.append((step.estimate, step.state, previous))
            if len(rows) == BLOCK:
                yield _stacked(rows)
                rows = []
        previous = step.state
    if rows:
        yield _stacked(rows)


def _stacked(rows: list[tuple[Estimate, State, State]]) -> Block:
    estimates, newest, previous = zip(*rows)
    stamp, *estimate = zip(*estimates)
    q, qd, measured_qd, effort = (
        _array([getattr(state, name) for state in newest])
        for name in ('q', 'qd', 'measured_qd', 'effort'))
    dt = np.array([now.stamp_ns - then.stamp_ns for now, then in zip(newest, previous)]) * 1e-9
    difference = (qd - _array([state.qd for state in previous])) / dt[:, None]
    return Block(Estimate(np.array(stamp), *map(_array, estimate)), q, qd, measured_qd, effort,
                 dt, difference)


def _array(values: Iterable[Array | None]) -> Array:
    """Stack arrays (7,) to (n, 7), with NaN for None."""
    return np.concatenate(
        [_NOTHING if value is None else value for value in values]).reshape(-1, N_JOINTS)


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

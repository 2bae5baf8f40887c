"""Regularity of a recording's stamps: period, lost messages, deviation from a grid."""

from typing import NamedTuple

import numpy as np

from ..estimation.continuity import GAP
from ..model.arrays import Array, Indices

_FEW = 20  # intervals below which nothing can be concluded


class StampStatistics(NamedTuple):
    """Regularity of stamps."""

    duration: float  # time covered, without gaps [s]
    rate: float  # stamps per second in that time [Hz]
    period: float  # of the grid [s]; zero if there are too few stamps
    irregularity: float  # RMS distance of an interval from the grid, as a share of the period
    lost: int  # points of the grid without a stamp, gaps left out


class StampClock:
    """
    Stamp statistics, and a time axis without jumps back.

    The robot's own stamps lie on a grid, however many messages are lost; times of arrival do not.
    """

    def __init__(self) -> None:
        self._last: int | None = None  # stamp [ns]
        self._now = 0.0  # end of the time axis [s]
        self._intervals: list[Array] = []  # [s]

    def elapsed(self, stamps_ns: Indices, intervals: Array) -> Array:
        """
        Return the time since the first stamp (n,) [s], constant where stamps go back.

        Parameters
        ----------
        stamps_ns : ndarray (n,)
            Stamps [ns].
        intervals : ndarray (n,)
            Time since the previous message, which may have been left out [s].

        """
        first = stamps_ns[0] if self._last is None else self._last
        self._last = stamps_ns[-1]
        self._intervals.append(intervals[(intervals > 0.0) & (intervals <= GAP)])
        steps = np.maximum(np.diff(stamps_ns, prepend=first), 0)
        time: Array = self._now + np.cumsum(steps * 1e-9)
        self._now = float(time[-1])
        return time

    def result(self) -> StampStatistics:
        """Return the statistics of all stamps so far."""
        dt = np.concatenate([np.empty(0), *self._intervals])
        duration = float(dt.sum())
        rate = len(dt) / duration if duration else 0.0
        if len(dt) < _FEW:
            return StampStatistics(duration, rate, 0.0, 0.0, 0)
        # If most messages are lost, the median is a multiple of the period.
        irregularity, period = min(
            _distance(dt, float(np.quantile(dt, share))) for share in (0.5, 0.05))
        steps = np.maximum(np.rint(dt / period), 1.0)
        return StampStatistics(duration, rate, period, irregularity, int((steps - 1.0).sum()))


def _distance(dt: Array, period: float) -> tuple[float, float]:
    """Return the RMS distance of intervals from multiples of a period, in periods; and it."""
    steps = dt / period
    return float(np.sqrt(np.mean((steps - np.maximum(np.rint(steps), 1.0)) ** 2))), period

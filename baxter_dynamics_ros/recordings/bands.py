"""Signals of any length, reduced for figures without losing a peak."""

from collections.abc import Iterable

import numpy as np

from .evaluation_results import Band
from ..model.arrays import Array
from ..model.joints import N_JOINTS

INTERVALS = 1000  # maximum; then they are merged in pairs
_FIRST_WIDTH = 0.01  # [s]


class RunningBands:
    """Ranges of signals within intervals of time, which widen as the recording goes on."""

    def __init__(self, names: Iterable[str]) -> None:
        self._names = tuple(names)
        self._width = _FIRST_WIDTH
        shape = (INTERVALS, len(self._names), N_JOINTS)
        self._low, self._high = np.full(shape, np.inf), np.full(shape, -np.inf)
        self._used = 0

    def add(self, time: Array, signals: Array) -> None:
        """Add samples at times (n,) [s], not decreasing, of signals (n, names, 7), or NaN."""
        if not len(time):
            return
        while time[-1] >= INTERVALS * self._width:
            self._widen()
        interval = (time / self._width).astype(int)
        first = np.flatnonzero(np.diff(interval, prepend=-1))
        where = interval[first]
        self._low[where] = np.fmin(self._low[where], np.fmin.reduceat(signals, first))
        self._high[where] = np.fmax(self._high[where], np.fmax.reduceat(signals, first))
        self._used = interval[-1] + 1

    def result(self) -> tuple[Array, dict[str, Band]]:
        """Return the middles of the intervals (m,) [s], and name -> Band, NaN where empty."""
        time = (np.arange(self._used, dtype=float) + 0.5) * self._width
        empty = self._low[:self._used] > self._high[:self._used]
        low = np.where(empty, np.nan, self._low[:self._used])
        high = np.where(empty, np.nan, self._high[:self._used])
        return time, {name: Band(low[:, i], high[:, i]) for i, name in enumerate(self._names)}

    def _widen(self) -> None:
        half = INTERVALS // 2
        for values, join, nothing in ((self._low, np.minimum, np.inf),
                                      (self._high, np.maximum, -np.inf)):
            values[:half] = join(values[::2], values[1::2])
            values[half:] = nothing
        self._width *= 2

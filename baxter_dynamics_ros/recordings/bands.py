"""Signals of any length, reduced for figures without losing a peak."""

from collections.abc import Iterable

import numpy as np

from .evaluation_results import Band
from ..model.arrays import Array
from ..model.joints import N_JOINTS

INTERVALS = 400  # maximum; then they are merged in pairs
_FIRST_WIDTH = 0.01  # [s]


class RunningBands:
    """Ranges of signals within intervals of time, which widen as the recording goes on."""

    def __init__(self, names: Iterable[str]) -> None:
        self._names = tuple(names)
        self._width = _FIRST_WIDTH
        self._used = 0
        self._low = np.full((INTERVALS, len(self._names), N_JOINTS), np.nan)
        self._high = self._low.copy()

    def add(self, time: Array, signals: Array) -> None:
        """Add samples at times (n,) [s], not decreasing, of signals (n, names, 7), or NaN."""
        while time[-1] >= INTERVALS * self._width:
            self._low = self._merged(self._low, np.fmin)
            self._high = self._merged(self._high, np.fmax)
            self._width *= 2
        interval = (time / self._width).astype(int)
        first = np.flatnonzero(np.diff(interval, prepend=-1))
        where = interval[first]
        self._low[where] = np.fmin(self._low[where], np.fmin.reduceat(signals, first))
        self._high[where] = np.fmax(self._high[where], np.fmax.reduceat(signals, first))
        self._used = interval[-1] + 1

    def result(self) -> tuple[Array, dict[str, Band]]:
        """Return the middles of the intervals (m,) [s], and name -> Band, NaN where empty."""
        time = (np.arange(self._used, dtype=float) + 0.5) * self._width
        return time, {name: Band(self._low[:self._used, i], self._high[:self._used, i])
                      for i, name in enumerate(self._names)}

    @staticmethod
    def _merged(values: Array, join: np.ufunc) -> Array:
        pairs = join(values[::2], values[1::2])
        return np.concatenate([pairs, np.full_like(pairs, np.nan)])

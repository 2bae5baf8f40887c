"""Buffer of recent samples, interpolated at earlier times."""

from bisect import bisect_right
from operator import itemgetter

import numpy as np

from ..model.arrays import Array

DURATION = 0.7  # retention time, longer than the largest configurable delay [s]
_MAX_SAMPLES = 1024  # bounds memory if stamps hardly advance
_TIME = itemgetter(0)


class DelayLine:
    """Buffer of position and effort over time."""

    def __init__(self) -> None:
        self._samples: list[tuple[float, Array, Array | None]] = []

    def reset(self) -> None:
        """Forget all samples."""
        self._samples.clear()

    def append(self, t: float, q: Array, effort: Array | None) -> None:
        """
        Add position q (7,) [rad] and effort (7,) [N m] or None at time t [s].

        Times must not decrease; a sample with the last time replaces the last sample.
        """
        samples = self._samples
        if samples and samples[-1][0] == t:
            samples.pop()
        samples.append((t, q, effort))
        while len(samples) > _MAX_SAMPLES or len(samples) > 1 and samples[1][0] <= t - DURATION:
            del samples[0]

    def at(self, t: float) -> tuple[Array, Array | None] | None:
        """
        Return the linearly interpolated position and effort at t [s], at most the last time.

        Returns
        -------
        tuple (ndarray (7,), ndarray (7,) or None), or None
            None if t is before the first sample. The effort is None if either neighbouring sample
            has none.

        """
        samples = self._samples
        after = bisect_right(samples, t, key=_TIME)
        if after == 0:
            return None
        t0, q0, effort0 = samples[after - 1]
        if t == t0 or after == len(samples):
            return q0, effort0
        t1, q1, effort1 = samples[after]
        w = np.array((t - t0) / (t1 - t0))  # multiplies faster than a float
        q = q0 + w * (q1 - q0)
        if effort0 is None or effort1 is None:
            return q, None
        return q, effort0 + w * (effort1 - effort0)

"""What was measured a moment ago: position and effort, interpolated at an earlier time."""

from collections import deque

import numpy as np

from ..model.arrays import Array

_MAX_SAMPLES = 1024  # stamps that hardly advance would fill the delay without end


class DelayLine:
    """Remembers samples just long enough to interpolate between two of them."""

    def __init__(self) -> None:
        self._samples: deque[tuple[float, Array, Array | None]] = deque(
            maxlen=_MAX_SAMPLES)

    def reset(self) -> None:
        """Forget all samples."""
        self._samples.clear()

    def append(self, t: float, q: Array, effort: Array | None) -> None:
        """
        Take position q (7,) [rad] and effort (7,) [N m] or None at t [s], not before the last.

        A sample at the time of the last replaces it.
        """
        if self._samples and self._samples[-1][0] == t:
            self._samples.pop()
        self._samples.append((t, q, effort))

    def at(self, t: float) -> tuple[Array, Array | None] | None:
        """
        Return position and effort at t [s], not after the last sample, linearly interpolated.

        Samples before t are forgotten but for the last of them, so t should not run back.

        Returns
        -------
        tuple (ndarray (7,), ndarray (7,) or None), or None
            None in all where t is before the first sample; None for the effort where a sample
            beside t has none.

        """
        samples = self._samples
        while len(samples) > 1 and samples[1][0] <= t:
            samples.popleft()
        t0, q0, effort0 = samples[0]
        if t < t0:
            return None
        if len(samples) == 1:
            return q0, effort0
        t1, q1, effort1 = samples[1]
        if t == t0:
            return q0, effort0
        w = np.array((t - t0) / (t1 - t0))  # multiplies faster than a float
        q = q0 + w * (q1 - q0)
        if effort0 is None or effort1 is None:
            return q, None
        return q, effort0 + w * (effort1 - effort0)

"""Velocity from positions, for joint states without velocity."""

from collections import deque

import numpy as np

from .continuity import SHORTEST_PERIOD
from ..model.arrays import Array

WINDOW = 0.030  # [s]
_TOLERANCE = 0.1  # share of the window; keeps jitter from changing the number of samples
_MAX_SAMPLES = 256  # bounds memory if stamps hardly advance


class PositionSlope:
    """
    Least-squares slope of the positions of the last 30 ms.

    The window is longer at low rates and for bursts, because a slope over less than
    SHORTEST_PERIOD is meaningless.

    Attributes
    ----------
    lag : float
        Time by which the slope lags the last position [s].

    """

    def __init__(self) -> None:
        self._samples: deque[tuple[float, Array]] = deque(maxlen=_MAX_SAMPLES)
        self.reset()

    def reset(self) -> None:
        """Forget all samples."""
        self._samples.clear()
        self._slope: Array | None = None  # [rad/s]
        self.lag = 0.0

    def update(self, t: float, q: Array) -> Array:
        """Add position q (7,) [rad] at t [s]; return the slope (7,) [rad/s], zero at first."""
        samples = self._samples
        if samples and samples[-1][0] == t:
            samples.pop()
        samples.append((t, q))
        while (samples[0][0] < t - WINDOW * (1 + _TOLERANCE)
               and samples[1][0] <= t - SHORTEST_PERIOD):
            samples.popleft()
        if samples[0][0] > t - SHORTEST_PERIOD:
            return np.zeros(np.shape(q)) if self._slope is None else self._slope
        times, positions = map(np.array, zip(*samples))
        mean = times.mean()
        weights = times - mean
        self.lag = t - mean
        self._slope = weights @ positions / (weights @ weights)
        return self._slope

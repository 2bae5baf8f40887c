"""Running statistics of a recording, in memory that does not grow with it."""

import numpy as np

from .evaluation_results import ErrorStatistics
from ..model.arrays import Array
from ..model.joints import N_JOINTS


class RunningErrors:
    """Running error statistics of a predicted effort."""

    def __init__(self) -> None:
        self._count = 0
        self._absolute = np.zeros(N_JOINTS)
        self._mean = np.zeros((2, N_JOINTS))  # of measured and predicted effort [N m]
        self._scatter = np.zeros((2, 2, N_JOINTS))  # sums of products about the mean [N^2 m^2]

    def add(self, measured: Array, predicted: Array) -> None:
        """Add n samples of measured and predicted effort, each (n, 7) [N m]."""
        n = len(measured)
        if not n:
            return
        both = np.stack([measured, predicted])
        mean = both.mean(1)
        about = both - mean[:, None]
        self._merge(n, np.abs(measured - predicted).sum(0), mean,
                    np.einsum('anj,bnj->abj', about, about))

    def include(self, other: 'RunningErrors') -> None:
        """Add the samples of another."""
        if other._count:
            self._merge(other._count, other._absolute, other._mean, other._scatter)

    def _merge(self, count: int, absolute: Array, mean: Array, scatter: Array) -> None:
        """Pool two sets of moments without cancellation (Chan, Golub and LeVeque 1979)."""
        total = self._count + count
        shift = mean - self._mean
        self._scatter += scatter + shift[:, None] * shift[None] * (self._count * count / total)
        self._mean += shift * (count / total)
        self._absolute += absolute
        self._count = total

    def result(self) -> 'ErrorStatistics | None':
        """Return the statistics; None without samples."""
        if not self._count:
            return None
        error = self._mean[0] - self._mean[1]
        scatter = self._scatter
        spread = np.maximum(scatter[0, 0] + scatter[1, 1] - 2 * scatter[0, 1], 0.0)
        with np.errstate(invalid='ignore', divide='ignore'):
            correlation = scatter[0, 1] / np.sqrt(scatter[0, 0] * scatter[1, 1])
        return ErrorStatistics(
            count=self._count,
            rms=np.sqrt(spread / self._count + error ** 2),
            mean_abs=self._absolute / self._count,
            signed_mean=error,
            correlation=correlation)


class RunningSquares:
    """Running RMS of several signals."""

    def __init__(self) -> None:
        self._count = 0
        self._squares: dict[str, Array] = {}

    def add(self, **signals: Array) -> None:
        """Add n samples of each signal, (n, 7)."""
        for name, values in signals.items():
            self._squares[name] = self._squares.get(name, 0.0) + (values * values).sum(0)
        self._count += len(values)

    def include(self, other: 'RunningSquares') -> None:
        """Add the samples of another."""
        for name, squares in other._squares.items():
            self._squares[name] = self._squares.get(name, 0.0) + squares
        self._count += other._count

    def result(self) -> dict[str, Array]:
        """Return signal name -> RMS (7,)."""
        return {name: np.sqrt(squares / self._count) for name, squares in self._squares.items()}

"""Running statistics of recordings, in memory that does not grow with them."""

import numpy as np

from .evaluation_results import (Errors, ErrorStatistics, ESTIMATORS, Expected, METHODS,
                                 Statistics, TERMS)
from ..model.arrays import Array
from ..model.effort import BAND
from ..model.joints import N_JOINTS


class RunningErrors:
    """Running error statistics of a predicted effort."""

    def __init__(self) -> None:
        self._count = 0
        self._origin = np.zeros(N_JOINTS)  # first measured effort, so that sums do not cancel
        self._sums = np.zeros((8, N_JOINTS))

    def add(self, measured: Array, predicted: Array) -> None:
        """Add n samples of measured and predicted effort, each (n, 7) [N m]."""
        if not len(measured):
            return
        if not self._count:
            self._origin = measured[0]
        self._count += len(measured)
        error, m, p = measured - predicted, measured - self._origin, predicted - self._origin
        self._sums += [x.sum(0) for x in (np.abs(error), error, error * error, m, p, m * m, p * p,
                                          m * p)]

    def result(self) -> 'ErrorStatistics | None':
        """Return the statistics; None without samples."""
        if not self._count:
            return None
        mean_abs, signed_mean, square, m, p, mm, pp, mp = self._sums / self._count
        variances = [np.where(x > 1e-12, x, np.nan) for x in (mm - m * m, pp - p * p)]
        return ErrorStatistics(self._count, np.sqrt(square), mean_abs, signed_mean,
                               (mp - m * p) / np.sqrt(variances[0] * variances[1]))


class RunningStatistics:
    """Running errors of each method and estimator, and RMS of each term."""

    def __init__(self) -> None:
        self._arms: set[str] = set()
        self._errors = {name: RunningErrors() for name in METHODS + ESTIMATORS}
        self._squares = {name: np.zeros(N_JOINTS) for name in TERMS}
        self._count = 0
        self._expected = np.zeros((2, N_JOINTS))  # square of the deviation; residuals within

    def add(self, arm: str, efforts: dict[str, tuple[Array, Array]], terms: dict[str, Array],
            deviation: Array) -> None:
        """
        Add n samples of an arm.

        Parameters
        ----------
        arm : str
            'right' or 'left'.
        efforts : dict
            Name of a method or an estimator to measured and predicted effort, (n, 7) [N m]; rows
            with NaN are left out.
        terms : dict
            Each term of the predicted effort, (n, 7) [N m].
        deviation : ndarray (n, 7)
            Expected standard deviation of the residual [N m].

        """
        self._arms.add(arm)
        for name, pair in efforts.items():
            valid = np.isfinite(pair[0][:, 0]) & np.isfinite(pair[1][:, 0])
            self._errors[name].add(*(x[valid] for x in pair))
        for name, values in terms.items():
            self._squares[name] += (values * values).sum(0)
        self._count += len(values)
        residual = np.subtract(*efforts['lagrange_euler'])
        valid = np.isfinite(residual[:, :1])
        self._expected += np.sum([np.where(valid, deviation ** 2, 0.0),
                                  np.abs(residual) <= BAND * deviation], axis=1)

    def result(self) -> Statistics:
        """Return the statistics of all samples so far."""
        shares = {name: np.sqrt(squares / self._count)
                  for name, squares in self._squares.items() if self._count}
        methods = self._results(METHODS)
        expected = None
        if methods and self._expected[0].all():
            square, within = self._expected / methods['lagrange_euler'].count
            expected = Expected(np.sqrt(square), within)
        return Statistics(', '.join(sorted(self._arms)), methods, self._results(ESTIMATORS),
                          shares, expected)

    def _results(self, names: tuple[str, ...]) -> Errors:
        results = {name: self._errors[name].result() for name in names}
        return {name: result for name, result in results.items() if result is not None}

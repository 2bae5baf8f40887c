"""Results of the evaluation of recordings, and the sums and ranges that they are made of."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .data_check import DataCheck, Notice
from .playback import Contact
from ..estimation.explanation import Explained
from ..model import Array, BAND, N_JOINTS

METHODS = ('lagrange_euler', 'newton_euler')
# Of the acceleration: the paper's, the node's with align false, the node's.
ESTIMATORS = ('first_difference', 'butterworth_live', 'butterworth_aligned')
TERMS = ('inertial', 'coriolis', 'gravity', 'spring', 'friction', 'other')  # of the effort

INTERVALS = 400  # maximum number in a figure
_FIRST_WIDTH = 0.01  # of the intervals, doubled when they become too many [s]


class ErrorStatistics(NamedTuple):
    """Statistics of the errors e = measured - predicted effort; arrays (7,) in joint order."""

    count: int  # type: ignore[assignment]  # samples; a tuple has a method of that name
    rms: Array  # sqrt(mean(e^2)) [N m]
    mean_abs: Array  # mean(|e|) [N m]
    signed_mean: Array  # mean(e) [N m]; the paper's Table V has its absolute value
    correlation: Array  # of measured and predicted effort; NaN where one of them is constant


class Band(NamedTuple):
    """Range of a signal within each interval of time; NaN where an interval has no sample."""

    low: Array  # (m, 7)
    high: Array  # (m, 7)


class Expected(NamedTuple):
    """Residual compared with its expected standard deviation; arrays (7,) in joint order."""

    deviation: Array  # RMS of the expected standard deviation [N m]
    coverage: Array  # share of the residuals within 1.96 expected deviations


Errors = dict[str, ErrorStatistics]  # by the name of a method or an estimator


@dataclass(frozen=True, eq=False)
class Statistics:
    """Results over one recording or several."""

    arm: str  # or both arms
    methods: Errors  # of each of METHODS; empty if there is no valid effort
    estimators: Errors  # of the Lagrange-Euler effort with each of ESTIMATORS
    shares: dict[str, Array]  # each of TERMS -> its RMS, (7,) [N m]; empty without predictions
    expected: 'Expected | None'  # None if there is no valid effort or no expectation


@dataclass(frozen=True, eq=False)
class Evaluation(Statistics):
    """Results for one recording."""

    name: str
    topic: str
    duration: float  # time with predictions, without gaps [s]
    rate: float  # predictions per second in that time, one per joint state [Hz]
    counts: dict[Any, int]  # event value (str), 'received', 'taken' and 'predicted'
    notices: tuple[Notice, ...]  # to read before the numbers; those of the data check first
    time: Array  # (m,) middle of each interval of the bands, since the start [s]
    # 'measured' and METHODS (effort), 'error_' + each of METHODS, and 'deviation' (expected
    # standard deviation of the error) [N m].
    bands: dict[str, Band]
    check: 'DataCheck | None' = None  # None if too few samples have effort or are plausible
    contacts: tuple[Contact, ...] = ()  # where the residual exceeds errors of the model
    explained: tuple[Explained, ...] = ()  # what explains the residual, every ten seconds


class RunningStatistics:
    """Running sums of the errors of each method and estimator, and of the squares of each term."""

    def __init__(self) -> None:
        self._arms: set[str] = set()
        self._count = 0  # samples, with effort or without
        self._sums: dict[str, Any] = defaultdict(float)  # by method, estimator, term; 'expected'
        self._origins: dict[str, Array] = {}  # first measured efforts, so that sums do not cancel

    def add(self, arm: str, efforts: dict[str, tuple[Array, Array]], terms: dict[str, Array],
            deviation: Array) -> None:
        """
        Add measured and predicted efforts, terms, and expected deviations of the residual.

        All are (n, 7) [N m]; rows of efforts with NaN are left out.
        """
        self._arms.add(arm)
        self._count += len(deviation)
        for name, pair in efforts.items():
            valid = np.isfinite(pair[0][:, 0]) & np.isfinite(pair[1][:, 0])
            if valid.any():
                measured, predicted = (x[valid] for x in pair)
                origin = self._origins.setdefault(name, measured[0])
                e, m, p = measured - predicted, measured - origin, predicted - origin
                self._sums[name] += np.array([x.sum(0) for x in (
                    np.ones_like(e), e * e, np.abs(e), e, m, p, m * m, p * p, m * p)])
        for name, values in terms.items():
            self._sums[name] += (values * values).sum(0)
        residual = np.subtract(*efforts['lagrange_euler'])
        valid = np.isfinite(residual[:, :1])
        self._sums['expected'] += np.sum([np.where(valid, deviation ** 2, 0.0),
                                          np.abs(residual) <= BAND * deviation], axis=1)

    def result(self) -> Statistics:
        """Return the statistics of all samples so far."""
        methods, estimators = ({name: _errors(self._sums[name]) for name in names
                                if name in self._origins} for names in (METHODS, ESTIMATORS))
        shares = {name: np.sqrt(self._sums[name] / self._count) for name in TERMS if self._count}
        expected = None
        if methods and self._sums['expected'][0].all():
            square, within = self._sums['expected'] / methods['lagrange_euler'].count
            expected = Expected(np.sqrt(square), within)
        return Statistics(', '.join(sorted(self._arms)), methods, estimators, shares, expected)


def _errors(sums: Array) -> ErrorStatistics:
    count = int(sums[0, 0])
    square, mean_abs, signed_mean, m, p, mm, pp, mp = sums[1:] / count
    variances = [np.where(x > 1e-12, x, np.nan) for x in (mm - m * m, pp - p * p)]
    return ErrorStatistics(count, np.sqrt(square), mean_abs, signed_mean,
                           (mp - m * p) / np.sqrt(variances[0] * variances[1]))


class RunningBands:
    """Ranges of signals in intervals of time that widen with the recording; no peak is lost."""

    def __init__(self, names: Iterable[str]) -> None:
        self._names = tuple(names)
        self._width = _FIRST_WIDTH
        self._used = 0  # intervals
        # Lowest and highest values.
        self._ranges = np.full((2, INTERVALS, len(self._names), N_JOINTS), np.nan)

    def add(self, time: Array, signals: Array) -> None:
        """Add signals (n, names, 7), or NaN, at times (n,) [s] that do not decrease."""
        if not len(time):
            return
        while time[-1] >= INTERVALS * self._width:
            for values, join in zip(self._ranges, (np.fmin, np.fmax)):
                values[:INTERVALS // 2] = join(values[::2], values[1::2])
                values[INTERVALS // 2:] = np.nan
            self._width *= 2
        interval = (time / self._width).astype(int)
        first = np.flatnonzero(np.diff(interval, prepend=-1))
        for values, join in zip(self._ranges, (np.fmin, np.fmax)):
            where = interval[first]
            values[where] = join(values[where], join.reduceat(signals, first))
        self._used = interval[-1] + 1

    def result(self) -> tuple[Array, dict[str, Band]]:
        """Return the middles of the intervals (m,) [s], and the range of each signal in them."""
        low, high = self._ranges[:, :self._used]
        return (np.arange(self._used, dtype=float) + 0.5) * self._width, {
            name: Band(low[:, i], high[:, i]) for i, name in enumerate(self._names)}

"""Results of the evaluation of one recording."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from .contact_intervals import Contact
from .data_check import DataCheck
from .notices import Notice
from ..estimation.explanation import Explained
from ..model.arrays import Array

METHODS = ('lagrange_euler', 'newton_euler')
# Of the acceleration: the paper's, the node's with align false, the node's.
ESTIMATORS = ('first_difference', 'butterworth_live', 'butterworth_aligned')
TERMS = ('inertial', 'coriolis', 'gravity', 'spring', 'friction', 'other')  # of the effort


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
    check: 'DataCheck | None' = None  # None if too few samples have effort
    contacts: tuple[Contact, ...] = ()  # where the residual exceeds errors of the model
    explained: tuple[Explained, ...] = ()  # what explains the residual, every ten seconds

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return the notices as lines of text."""
        return tuple(map(str, self.notices))

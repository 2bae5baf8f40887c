"""What an evaluation finds about one recording: plain numbers, for reports and for people."""

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from .contact_intervals import Contact
from .data_check import DataCheck
from .notices import Notice
from ..model.arrays import Array

METHODS = ('lagrange_euler', 'newton_euler')
# How the acceleration is found: the paper's way, the node's with align false, the node's.
ESTIMATORS = ('first_difference', 'butterworth_live', 'butterworth_aligned')
# What the predicted effort is made of.
TERMS = ('inertial', 'coriolis', 'gravity', 'spring', 'friction', 'other')


class ErrorStatistics(NamedTuple):
    """Of the errors e = measured - predicted effort; arrays (7,) in joint order."""

    count: int  # type: ignore[assignment]  # samples; a tuple has a method of that name
    rms: Array  # sqrt(mean(e^2)) [N m]
    mean_abs: Array  # mean(|e|) [N m]
    signed_mean: Array  # mean(e) [N m]; the paper's Table V has its absolute value
    correlation: Array  # of measured and predicted effort; NaN where one of them is constant


class Band(NamedTuple):
    """A signal, thinned out for a picture: what it spans within each interval of time."""

    low: Array  # (m, 7)
    high: Array  # (m, 7)


Errors = dict[str, ErrorStatistics]  # by the name of a method or an estimator


class Statistics(Protocol):
    """What was found, over one recording or all of them; see :class:`Evaluation`."""

    @property
    def arm(self) -> str:
        """Return which arm was judged."""

    @property
    def methods(self) -> Errors:
        """Return the errors of each method."""

    @property
    def estimators(self) -> Errors:
        """Return the errors with each estimator."""

    @property
    def shares(self) -> dict[str, Array]:
        """Return the RMS of each term of the predicted effort."""


@dataclass(frozen=True, eq=False)
class Evaluation:
    """
    What was found about one recording.

    Attributes
    ----------
    name, topic, arm : str
        The recording's name, its topic, and which arm was judged.
    duration : float
        Time in which effort was predicted, gaps left out [s].
    rate : float
        Predictions a second in that time, one a joint state [Hz].
    counts : dict
        Event value (str), 'received', 'taken', 'predicted' -> how often.
    notices : tuple of Notice
        What a reader should know before trusting the numbers; those of the data check first.
    methods : dict
        Each of METHODS -> ErrorStatistics; empty where there is no valid effort.
    estimators : dict
        Each of ESTIMATORS -> ErrorStatistics of the Lagrange-Euler effort with it.
    shares : dict
        Each of TERMS -> RMS of that term of the predicted effort, (7,) [N m].
    time : ndarray (m,)
        Middle of each interval of the bands, since the recording's start [s].
    bands : dict
        Signal -> Band [N m]: 'measured', 'lagrange_euler', 'newton_euler' (effort), and
        'error_' + each of METHODS and of ESTIMATORS. NaN where an interval has no sample.
    check : DataCheck or None
        Check of the data; None where there are too few samples with effort.
    contacts : tuple of Contact
        Where the residual is larger than errors of the model.

    """

    name: str
    topic: str
    arm: str
    duration: float
    rate: float
    counts: dict[Any, int]
    notices: tuple[Notice, ...]
    methods: Errors
    estimators: Errors
    shares: dict[str, Array]
    time: Array
    bands: dict[str, Band]
    check: 'DataCheck | None' = None
    contacts: tuple[Contact, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return the notices as lines of text."""
        return tuple(map(str, self.notices))

"""What has come in between two diagnostic reports."""

from collections import Counter

import numpy as np

from ..estimation.events import Event
from ..estimation.wrench import HandWrench
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS


class PeriodStatistics:
    """
    Counts and sums of the period between two reports, and what is remembered of the one before.

    Attributes
    ----------
    rate : float
        Of the joint states that were taken, in the period that was closed last [Hz].
    highest_rate : float
        The same, or that of the period before where it is greater [Hz]: at a start and an end a
        period is not full. Infinite where nothing came in the period before.
    dry : float
        For how long there have been joint states but no prediction [s].
    withheld : int
        How many wrenches were withheld since the start, near singularities.
    touched : ndarray (7,) of bool
        Which joints have shown a contact in this period.
    unexplained : float or None
        Of the last wrench: the joint torque that no wrench explains [N m].

    """

    def __init__(self) -> None:
        self._before: Counter[Event | str] = Counter()  # counts at the end of the last period
        self._counts: Counter[Event | str] = Counter()  # counts at the end of this
        self.rate = self.highest_rate = float('inf')
        self.dry = 0.0
        self.withheld = 0
        self.unexplained: float | None = None
        self._lost = 0
        self._failures = 0
        self.begin()

    def begin(self) -> None:
        """Begin a new period."""
        self._square = np.zeros(N_JOINTS)
        self._residuals = 0
        self.touched = np.zeros(N_JOINTS, dtype=bool)
        self._withheld_before = self.withheld

    def close(self, counts: Counter[Event | str], period: float) -> None:
        """End a period of ``period`` [s]; ``counts`` are those of now."""
        self._before, self._counts = self._counts, Counter(counts)
        before, self.rate = self.rate, self.since('taken') / period
        self.highest_rate = max(self.rate, before) if before else float('inf')
        is_dry = self.since('taken') > 0 and not self.since('predicted')
        self.dry = self.dry + period if is_dry else 0.0

    def add(self, residual: Array | None) -> None:
        """Take the residual (7,) [N m] of a prediction, or None."""
        if residual is not None:
            self._square += residual * residual
            self._residuals += 1

    def add_contact(self, joints: Bools) -> None:
        """Take the joints (7,) bool that show a contact."""
        self.touched |= joints

    def add_wrench(self, wrench: HandWrench | None) -> None:
        """Take a wrench, or None where it is withheld."""
        self.withheld += wrench is None
        self.unexplained = None if wrench is None else wrench.unexplained

    def failures_since(self, failures: int) -> int:
        """Return how many of all ``failures`` are new since the last call."""
        new, self._failures = failures - self._failures, failures
        return new

    def lost_since(self, lost: int) -> int:
        """Return how many of all ``lost`` messages are new since the last call."""
        new, self._lost = lost - self._lost, lost
        return new

    def since(self, event: Event | str) -> int:
        """Return how often an event occurred in the period that was closed last."""
        return self._counts[event] - self._before[event]

    @property
    def was_withheld(self) -> bool:
        """Whether a wrench was withheld in this period."""
        return self.withheld > self._withheld_before

    @property
    def residual_rms(self) -> 'Array | None':
        """RMS of the period's residuals (7,) [N m]; None if there were none."""
        return np.sqrt(self._square / self._residuals) if self._residuals else None

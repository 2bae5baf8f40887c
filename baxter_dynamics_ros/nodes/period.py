"""Statistics between two diagnostic reports."""

from collections import Counter

import numpy as np

from ..estimation.events import Event
from ..estimation.wrench import HandWrench
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS


class PeriodStatistics:
    """
    Counts and sums of the period between two reports.

    Attributes
    ----------
    rate : float
        Rate of accepted joint states in the last closed period [Hz].
    highest_rate : float
        Larger rate of the last two closed periods [Hz], as a stream may start or end within a
        period. Infinite if nothing arrived in the first of them.
    dry : float
        Time with joint states but without predictions [s].
    withheld : int
        Number of wrenches withheld near singularities since the start.
    touched : ndarray (7,) of bool
        Joints that have been in contact in this period.
    unexplained : float or None
        Joint torque that the last wrench does not explain [N m].

    """

    def __init__(self) -> None:
        self._before: Counter[Event | str] = Counter()  # counts at the end of the previous period
        self._counts: Counter[Event | str] = Counter()  # counts at the end of the last period
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
        """End a period of ``period`` [s] with the present counts."""
        self._before, self._counts = self._counts, Counter(counts)
        before, self.rate = self.rate, self.since('taken') / period
        self.highest_rate = max(self.rate, before) if before else float('inf')
        is_dry = self.since('taken') > 0 and not self.since('predicted')
        self.dry = self.dry + period if is_dry else 0.0

    def add(self, residual: Array | None) -> None:
        """Add the residual (7,) [N m] of a prediction; None is ignored."""
        if residual is not None:
            self._square += residual * residual
            self._residuals += 1

    def add_contact(self, joints: Bools) -> None:
        """Add the joints in contact, (7,) bool."""
        self.touched |= joints

    def add_wrench(self, wrench: HandWrench | None) -> None:
        """Add a wrench; None counts as withheld."""
        self.withheld += wrench is None
        self.unexplained = None if wrench is None else wrench.unexplained

    def failures_since(self, failures: int) -> int:
        """Return the number of failures since the last call, given their total."""
        new, self._failures = failures - self._failures, failures
        return new

    def lost_since(self, lost: int) -> int:
        """Return the number of messages lost since the last call, given their total."""
        new, self._lost = lost - self._lost, lost
        return new

    def since(self, event: Event | str) -> int:
        """Return how often an event occurred in the last closed period."""
        return self._counts[event] - self._before[event]

    @property
    def was_withheld(self) -> bool:
        """Whether a wrench was withheld in this period."""
        return self.withheld > self._withheld_before

    @property
    def residual_rms(self) -> 'Array | None':
        """RMS of the period's residuals (7,) [N m]; None if there were none."""
        return np.sqrt(self._square / self._residuals) if self._residuals else None

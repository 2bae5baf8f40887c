"""Statistics between two diagnostic reports."""

from collections import Counter

import numpy as np

from ..estimation.events import Event
from ..estimation.predictor import Step
from ..estimation.wrench import HandWrench
from ..model.arrays import Array
from ..model.joints import N_JOINTS


class PeriodStatistics:
    """Counts and sums of the period between two reports."""

    def __init__(self) -> None:
        # Counts since the start of the node, at the ends of the last period and the one before.
        self.counts: Counter[Event | str] = Counter()
        self._before = self.counts
        self.rate = float('inf')  # of accepted joint states in the last period [Hz]
        # Larger rate of the last two periods [Hz], as a stream may start or end within a period.
        # Infinite if nothing arrived in the first of them.
        self.highest_rate = float('inf')
        self.dry = 0.0  # time with joint states but without predictions [s]
        self.residual_rms: Array | None = None  # (7,) in the last period [N m]
        self.touched = np.zeros(N_JOINTS, dtype=bool)  # joints in contact in the last period
        self.unexplained: float | None = None  # torque that the last wrench leaves over [N m]
        self._withheld = 0  # number of wrenches
        self._begin()

    def _begin(self) -> None:
        self._square = np.zeros(N_JOINTS)
        self._residuals = 0
        self._touched = np.zeros(N_JOINTS, dtype=bool)

    def add(self, step: Step) -> None:
        """Add the results of a joint state."""
        if step.prediction is not None and step.prediction.residual is not None:
            self._square += step.prediction.residual ** 2
            self._residuals += 1
        if step.external is not None and step.external.contact:
            self._touched |= step.external.joints

    def add_wrench(self, wrench: HandWrench | None) -> None:
        """Add a wrench; None counts as withheld."""
        self._withheld += wrench is None
        self.unexplained = None if wrench is None else wrench.unexplained

    def close(self, counts: Counter[Event | str], period: float) -> None:
        """End a period of ``period`` [s] with the present counts, and begin the next."""
        self._before, self.counts = self.counts, Counter({**counts, 'withheld': self._withheld})
        before, self.rate = self.rate, self.since('taken') / period
        self.highest_rate = max(self.rate, before) if before else float('inf')
        is_dry = self.since('taken') > 0 and not self.since('predicted')
        self.dry = self.dry + period if is_dry else 0.0
        self.residual_rms = (
            np.sqrt(self._square / self._residuals) if self._residuals else None)
        self.touched = self._touched
        self._begin()

    def since(self, event: Event | str) -> int:
        """Return how often an event occurred in the last period."""
        return self.counts[event] - self._before[event]

"""Newest results of a stream, and statistics of its last period."""

from collections import Counter
from collections.abc import Callable
import time

import numpy as np

from ..estimation.events import Event
from ..estimation.external import HandWrench
from ..estimation.predictor import Step
from ..model import Array, N_JOINTS, rms

MAX_AGE = 1.0  # age from which a measured state is out of date [s]


class MessageLoss:
    """
    Counts messages lost by the middleware: gaps in the sequence numbers of the publishers.

    rclpy does not report the publisher of a message, so each number is attributed to the publisher
    whose last number it follows most closely. The middleware's own message-lost event does not
    count messages that a full queue replaces.
    """

    def __init__(self) -> None:
        self.lost = 0  # number of messages
        self._last: list[int] = []  # sequence number of each publisher's newest message
        self._new = 0  # publishers that have matched but not sent anything yet

    def matched(self, change: int) -> None:
        """Process a change in the total number of matched publishers."""
        self._new += change

    def received(self, number: int | None) -> None:
        """Process the sequence number of a message; None if the middleware provides none."""
        if number is None:
            return
        before = [last for last in self._last if last < number]
        if before and (max(before) == number - 1 or not self._new):
            self._last.remove(max(before))
            self.lost += number - 1 - max(before)
        else:
            self._new = max(self._new - 1, 0)
        self._last = [*self._last, number][-16:]  # publishers come and go


class StepStatistics:
    """Newest steps with their age by a clock [s], and statistics of the last period."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.accepted = Step()  # of the last accepted joint state; empty before
        # Of the last one with a prediction; empty after a restart of the stream.
        self.predicted = Step()
        self.loss = MessageLoss()
        # Counts since the start, at the end of the last period and at its beginning.
        self.counts: Counter[Event | str] = Counter()
        self._before = self.counts
        self.rate = float('inf')  # of accepted joint states in the last period [Hz]
        # Larger rate of the last two periods [Hz], as a stream may start or end within a period.
        # Infinite if nothing arrived in one of them.
        self.highest_rate = float('inf')
        self.dry = 0.0  # time with joint states but without predictions [s]
        self.residual_rms: Array | None = None  # (7,) in the last period [N m]
        self.touched = np.zeros(N_JOINTS, dtype=bool)  # joints in contact in the last period
        self.unexplained: float | None = None  # torque that the last wrench leaves over [N m]
        self._clock = clock
        self._accepted_at = -float('inf')  # [s]
        self._withheld = 0  # number of wrenches
        self._residuals: list[Array] = []
        self._touched = self.touched

    @property
    def age(self) -> float:
        """Time since the last accepted joint state [s]; infinite if there was none."""
        return self._clock() - self._accepted_at

    def add(self, step: Step) -> None:
        """Add the results of a joint state."""
        if step.dropped is not None:
            return
        self.accepted, self._accepted_at = step, self._clock()
        if step.begins or step.estimate is not None:
            self.predicted = step
        if step.prediction is not None and step.prediction.residual is not None:
            self._residuals.append(step.prediction.residual)
        if step.external is not None and step.external.contact:
            self._touched = self._touched | step.external.joints

    def add_wrench(self, wrench: HandWrench | None) -> None:
        """Add a wrench; None counts as withheld."""
        self._withheld += wrench is None
        self.unexplained = None if wrench is None else wrench.unexplained

    def close(self, counts: Counter[Event | str], period: float) -> None:
        """End a period of ``period`` [s] with the present counts, and begin the next."""
        self._before, self.counts = self.counts, Counter({
            **counts, 'withheld': self._withheld, 'lost': self.loss.lost})
        before, self.rate = self.rate, self.since('taken') / period
        self.highest_rate = max(self.rate, before) if before and self.rate else float('inf')
        is_dry = self.since('taken') > 0 and not self.since('predicted')
        self.dry = self.dry + period if is_dry else 0.0
        self.residual_rms = rms(self._residuals) if self._residuals else None
        self.touched, self._touched = self._touched, np.zeros(N_JOINTS, dtype=bool)
        self._residuals = []

    def since(self, event: Event | str) -> int:
        """Return how often an event occurred in the last period."""
        return self.counts[event] - self._before[event]

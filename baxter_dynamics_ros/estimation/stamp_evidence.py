"""Evidence for and against header stamps, from the steps between them."""

from collections import deque

HEADER, ARRIVAL, RECEIPT = 'header', 'arrival', 'receipt'  # sources of stamps
AUTO = 'auto'
MODES = (AUTO, HEADER, ARRIVAL, RECEIPT)

# The robot publishes at 800 Hz or less. New data with a smaller step between stamps were stamped
# on arrival, or by a clock that stands still.
SHORT_STEP = 500_000  # [ns]
# This many short steps within _MESSAGES messages show that stamps are times of arrival.
_SHORT_STEPS = 3
_MESSAGES = 100
_EVEN_TIME = 5_000_000_000  # duration of even steps that restores header stamps [ns]
_LONG_STEP = 250_000_000  # a longer step interrupts an even stream [ns]
# A clock stands still if, in two consecutive windows of receipt time, nearly all steps are short
# and add up to a small share of that time.
_WINDOW = 500_000_000  # [ns]
_WINDOWS = 2
_WINDOW_MESSAGES = 5
_STILL_SHARE = 0.8  # of the messages
_STILL_ADVANCE = 0.1  # of the receipt time


class StampEvidence:
    """
    Decides whether header stamps are the robot's, times of arrival, or useless.

    Attributes
    ----------
    source : str
        HEADER, ARRIVAL (header stamps are times of arrival) or RECEIPT (header stamps stand
        still: use the time of receipt).

    """

    def __init__(self) -> None:
        self.source = HEADER
        self._last: tuple[int, int | None] | None = None  # stamp, receipt [ns]
        self._n = 0
        self._short: deque[int] = deque(maxlen=_SHORT_STEPS)  # message numbers
        self._even = 0  # [ns]
        self._still_windows = 0
        self._begin_window()

    def update(self, stamp_ns: int, fresh: bool, received_ns: 'int | None') -> str:
        """Evaluate a message, for the arguments see :meth:`.Retiming.update`; return source."""
        last, self._last = self._last, (stamp_ns, received_ns)
        if last is None:
            return self.source
        step = stamp_ns - last[0]
        if received_ns is not None and last[1] is not None:
            self._watch_clock(step, received_ns - last[1])
        if fresh:
            self._watch_steps(step)
        return self.source

    def _watch_steps(self, step: int) -> None:
        self._n += 1
        if 0 <= step < SHORT_STEP:
            self._short.append(self._n)
        self._even = self._even + step if SHORT_STEP <= step <= _LONG_STEP else 0
        if self._even >= _EVEN_TIME:
            self.source = HEADER
        elif (self.source == HEADER and len(self._short) == _SHORT_STEPS
                and self._n - self._short[0] < _MESSAGES):
            self.source = ARRIVAL
            self._short.clear()

    def _watch_clock(self, step: int, elapsed: int) -> None:
        self._elapsed += max(elapsed, 0)
        self._messages += 1
        if 0 <= step < SHORT_STEP:
            self._still += 1
            self._advance += step
        if self._elapsed < _WINDOW:
            return
        still = (self._messages >= _WINDOW_MESSAGES
                 and self._still > _STILL_SHARE * self._messages
                 and self._advance < _STILL_ADVANCE * self._elapsed)
        self._still_windows = self._still_windows + 1 if still else 0
        if self._still_windows >= _WINDOWS:
            self.source = RECEIPT
        self._begin_window()

    def _begin_window(self) -> None:
        self._elapsed = self._messages = self._still = self._advance = 0

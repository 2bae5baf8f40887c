"""Source of stamps: header stamps, or even stamps from a phase-locked loop."""

from collections import deque
from math import sqrt

from .events import Event

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

MEMORY = 2.0  # time constant of the line's phase [s]
LOCKING = 1.0  # minimum time before the line is used [s]
LOCKING_MESSAGES = 20  # minimum number of messages before the line is used
LATE = 0.02  # bound on the error that corrects the line [s]: a few messages are very late
# The line restarts after a larger error of one message, or a larger mean error: there was a pause,
# or the rate or the clock has changed.
FAR = 0.25  # error of one message [s]
ASIDE = 0.05  # mean error over ASIDE_TIME [s]
ASIDE_TIME = 0.5  # [s]
_BURST = 100  # a longer sequence of short steps is a high rate, not a delayed burst


class Retiming:
    """
    Source of stamps for a stream of joint states: header stamps or re-timed stamps.

    Re-timed stamps lag the robot's stamps by slightly less than the mean transport delay. The line
    counts messages, so a lost message shifts it by one period for a few seconds. The setting
    ``stamps`` gives the mode; 'auto' follows :class:`StampEvidence`.
    """

    def __init__(self, mode: str) -> None:
        self.mode = mode
        self.source = HEADER if mode == AUTO else mode  # in use
        self.event: Event | None = None  # RESET_... if the last message started a new time line
        self._line = ArrivalLine()
        self._evidence = StampEvidence()
        self._last: int | None = None  # stamp of the last message [ns]
        self._out: int | None = None  # stamp returned for it [ns]

    @property
    def retimed(self) -> bool:
        """Whether stamps are re-timed, or withheld until they can be."""
        return self.source != HEADER

    @property
    def period(self) -> 'float | None':
        """Time between two re-timed stamps [s]; None if there are none."""
        return self._line.period if self.retimed and self._line.locked else None

    @property
    def jitter(self) -> 'float | None':
        """RMS of arrivals minus re-timed stamps over the last MEMORY [s]; None if not re-timed."""
        return self._line.jitter if self.retimed and self._line.locked else None

    def select(self, stamp_ns: int, received_ns: 'int | None') -> int:
        """Return the stamp in use before re-timing [ns]: the header's, or the time of receipt."""
        if received_ns is not None and (stamp_ns == 0 or self.source == RECEIPT):
            return received_ns
        return stamp_ns

    def update(self, stamp_ns: int, fresh: bool, received_ns: 'int | None' = None
               ) -> 'int | None':
        """
        Process a header stamp, 0 if not set, and a time of receipt [ns]; return the stamp to use.

        ``fresh`` is false for data of the last message or of another publisher: the step is no
        evidence about the stamps, and an equal stamp returns the last result again. Re-timed
        stamps increase until there is an ``event``. None while the line is not locked.
        """
        self.event = None
        if self.mode == AUTO:
            self._weigh(stamp_ns, fresh, received_ns)
        stamp_ns = self.select(stamp_ns, received_ns)
        last, self._last = self._last, stamp_ns
        if last is not None and stamp_ns == last and not fresh:
            return self._out
        fits = last is None or self.mode == HEADER or self._line.update(stamp_ns - last)
        if not self.retimed:
            self._out = stamp_ns
        elif not self._line.locked:
            if self._out is not None and not fits:
                self.event = self.event or Event.RESET_RESYNC
            self._out = None
        else:
            even = stamp_ns + round(self._line.phase * 1e9)
            if self._out is not None and even <= self._out:
                return None  # the line is still behind the last header stamp returned
            self._out = even
        return self._out

    def _weigh(self, stamp_ns: int, fresh: bool, received_ns: int | None) -> None:
        before, self.source = self.source, self._evidence.update(stamp_ns, fresh, received_ns)
        if self.source != before:
            self.event = Event.RESET_STAMP_SOURCE
            if RECEIPT in (self.source, before) and stamp_ns:  # stamps of another clock
                self._line.restart()
                self._last = self._out = None


class StampEvidence:
    """Decides by the steps between stamps whether they are the robot's, arrivals, or useless."""

    def __init__(self) -> None:
        # HEADER, ARRIVAL (header stamps are times of arrival) or RECEIPT (they stand still).
        self.source = HEADER
        self._last: tuple[int, int | None] | None = None  # stamp, receipt [ns]
        self._short: deque[bool] = deque(maxlen=_MESSAGES)  # whether the last steps were short
        self._even = 0  # duration of even steps [ns]
        self._still_windows = 0
        self._begin_window()

    def update(self, stamp_ns: int, fresh: bool, received_ns: 'int | None') -> str:
        """Evaluate a message, for the arguments see :meth:`.Retiming.update`; return source."""
        last, self._last = self._last, (stamp_ns, received_ns)
        if last is not None:
            step = stamp_ns - last[0]
            is_short = 0 <= step < SHORT_STEP
            if received_ns is not None and last[1] is not None:
                self._watch_clock(step, is_short, received_ns - last[1])
            if fresh:
                self._watch_steps(step, is_short)
        return self.source

    def _watch_steps(self, step: int, is_short: bool) -> None:
        self._short.append(is_short)
        self._even = self._even + step if SHORT_STEP <= step <= _LONG_STEP else 0
        if self._even >= _EVEN_TIME:
            self.source = HEADER
        elif (is_short and self.source == HEADER
                and self._short.count(True) >= _SHORT_STEPS):
            self.source = ARRIVAL
            self._short.clear()

    def _watch_clock(self, step: int, is_short: bool, elapsed: int) -> None:
        self._elapsed += max(elapsed, 0)
        self._messages += 1
        self._still += is_short
        self._advance += step if is_short else 0
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
        self._elapsed = self._messages = self._still = self._advance = 0  # of short steps


class ArrivalLine:
    """
    Line of arrival time over message number, fitted by a phase-locked loop.

    With e the difference between an arrival and the last time t of the line plus one period T, the
    line is updated by ``t += T + g e`` and ``T += h e``. At first g and h fall as 1/n and 1/n^2,
    which gives the least-squares line of n arrivals. Their lower bounds ``g = T / MEMORY`` and
    ``h = g^2 / 2`` make the time constant the same at every rate.
    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Start again at the newest arrival."""
        self.period = 0.0  # T [s]
        self.phase = 0.0  # t minus the newest arrival [s]; small, so that a float loses no digits
        self.jitter = 0.0  # RMS of e over the last MEMORY [s]
        self.locked = False  # whether the line can be used
        self._n = 1
        self._skipped = 0  # messages of a delayed burst
        self._mean = 0.0  # of e [s]

    def update(self, step: int) -> bool:
        """Add an arrival, step [ns] after the last; return False if the line restarts at it."""
        if self._n == 1 and 0 <= step < SHORT_STEP and self._skipped < _BURST:
            self._skipped += 1
            return True  # part of a delayed burst: start at its end
        e = step * 1e-9 - self.phase - self.period
        if abs(e) > FAR:
            self.restart()
            return False
        self._n = n = self._n + 1
        gain = self.period / MEMORY
        g = max((4 * n - 2) / (n * (n + 1)), gain)
        h = max(6 / (n * (n + 1)), gain * gain / 2)
        pull = max(-LATE, min(e, LATE)) if self.locked else e
        self.phase = g * pull - e
        self.period += h * pull
        if not self.locked:
            self.locked = n >= LOCKING_MESSAGES and n * self.period >= LOCKING
            return True
        self.jitter = sqrt(self.jitter ** 2 + gain * (e * e - self.jitter ** 2))
        self._mean += self.period / ASIDE_TIME * (e - self._mean)
        if abs(self._mean) > ASIDE:
            self.restart()
            return False
        return True

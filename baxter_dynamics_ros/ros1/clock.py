"""Offset between a robot's clock and this machine's, from stamps and arrival times."""

from collections import deque

_WINDOW = 1_000_000_000  # [ns]; the fastest arrival of each window is kept
_WINDOWS = 10  # windows kept; a drift of 50 ppm changes the offset by 0.5 ms meanwhile
_SLEW = 0.002  # maximum rate of change of the offset: 20 us between stamps at 100 Hz
_EARLY = 100_000_000  # [ns]; no message arrives so early unless a clock was set
_LATE = 500_000_000  # [ns]; no window has only such late arrivals unless a clock was set
_LONGEST = 100_000_000  # [ns]; maximum time step of the slew


class ClockOffset:
    """
    Estimator of the offset between the robot's clock and this machine's.

    The fastest arrivals of the last ten seconds determine the offset. It changes by at most 0.2 %
    of the elapsed time, so that shifted stamps stay as even as the robot's. It restarts when one
    of the clocks is set.
    """

    def __init__(self) -> None:
        # This machine's clock minus the robot's, plus the minimum transport delay [ns].
        self.offset_ns = 0
        self.steps = 0  # number of restarts
        self.late_ns = 0  # delay of the last message beyond the minimum transport delay [ns]
        self._windows: deque[int] = deque(maxlen=_WINDOWS)
        self._fastest = 0  # of the present window [ns]
        self._window_began = 0  # time of arrival [ns]
        self._stamp: int | None = None  # of the last message [ns]

    def update(self, stamp_ns: int, arrival_ns: int) -> int:
        """Update the offset with the stamp and arrival of a message, and return it [ns]."""
        difference = arrival_ns - stamp_ns
        if self._stamp is None:
            self._begin(difference, arrival_ns)
        elif difference - self.offset_ns < -_EARLY:
            self.steps += 1
            self._begin(difference, arrival_ns)
        elif not 0 <= arrival_ns - self._window_began < _WINDOW:
            self._close_window(difference, arrival_ns)
        self._fastest = min(self._fastest, difference)
        self._slew(stamp_ns)
        self.late_ns = difference - self.offset_ns
        return self.offset_ns

    def _begin(self, difference: int, arrival_ns: int) -> None:
        self._windows.clear()
        self.offset_ns = self._fastest = difference
        self._window_began = arrival_ns

    def _close_window(self, difference: int, arrival_ns: int) -> None:
        if self._fastest - self.offset_ns > _LATE:
            self.steps += 1
            self._begin(self._fastest, arrival_ns)
        self._windows.append(self._fastest)
        self._fastest, self._window_began = difference, arrival_ns

    def _slew(self, stamp_ns: int) -> None:
        passed = 0 if self._stamp is None else stamp_ns - self._stamp
        most = int(_SLEW * min(max(passed, 0), _LONGEST))
        self._stamp = stamp_ns
        error = min((self._fastest, *self._windows)) - self.offset_ns
        self.offset_ns += min(max(error, -most), most)

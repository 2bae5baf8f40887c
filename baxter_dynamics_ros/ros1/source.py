"""Statistics of one publisher: lost and repeated messages, rate, jitter, clock offset."""

from collections import deque
import statistics

from .wire import JointState

_MEMORY = 10_000_000_000  # [ns]; a drift of 50 ppm changes the offset by 0.5 ms in it
_SLEW = 0.002  # maximum rate of change of the offset: 20 us between stamps at 100 Hz
_LONGEST = 100_000_000  # maximum time step of the slew [ns]
# A clock was set if one message is _EARLY before the offset, or _LATE after it with a stamp _LATE
# before the last one, or if all are _LATE after it for _LATE_FOR [ns].
_EARLY, _LATE, _LATE_FOR = 100_000_000, 500_000_000, 1_000_000_000


class Source:
    """Statistics of one publisher's messages, across reconnections."""

    def __init__(self, publisher: str) -> None:
        self.publisher = publisher
        self.clock = ClockOffset()
        self.received = 0  # number of messages
        self.lost = 0  # missing in the sequence numbers
        self.repeated = 0  # dropped
        self.rate = 0.0  # over the last period [Hz]
        self.jitter = 0.0  # standard deviation of the delay over the last period [s]
        self._uri = ''
        self._last: JointState | None = None
        self._delays: list[float] = []  # in this period [s]

    def take(self, uri: str, state: JointState, arrival_ns: int) -> bool:
        """Count a message with its time of arrival [ns], and return whether it is new."""
        if self._last and uri == self._uri:  # otherwise the sequence numbers have restarted
            if any(state[:2]) and state[:2] == self._last[:2]:  # number and stamp
                self.repeated += 1
                return False
            ahead = (state.seq - self._last.seq) % 2 ** 32
            self.lost += ahead - 1 if 1 < ahead < 2 ** 31 else 0  # otherwise out of order
        self._uri, self._last = uri, state
        self.received += 1
        late = 0
        if state.stamp_ns:
            late = arrival_ns - state.stamp_ns - self.clock.update(state.stamp_ns, arrival_ns)
        self._delays.append(late * 1e-9)
        return True

    def close_period(self, seconds: float) -> None:
        """Compute rate and jitter of a period of ``seconds`` [s] and start the next."""
        delays, self._delays = self._delays, []
        self.rate = len(delays) / seconds
        self.jitter = statistics.pstdev(delays) if delays else 0.0


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
        self._stamp_ns = 0  # of the last message
        # Arrival and difference of the clocks [ns] of each message that is faster than all later.
        self._fastest: deque[tuple[int, int]] = deque()
        self._late_since: int | None = None  # arrival of the first of the late messages [ns]

    def update(self, stamp_ns: int, arrival_ns: int) -> int:
        """Update the offset with the stamp and arrival of a message, and return it [ns]."""
        difference = arrival_ns - stamp_ns
        if not self._fastest:
            self.offset_ns = difference
        while self._fastest and self._fastest[-1][1] >= difference:
            self._fastest.pop()
        self._fastest.append((arrival_ns, difference))
        late = difference - self.offset_ns
        if late <= _LATE:
            self._late_since = None
        elif self._late_since is None:
            self._late_since = arrival_ns
        is_set_back = late > _LATE and stamp_ns < self._stamp_ns - _LATE
        stays_late = (self._late_since is not None
                      and arrival_ns - self._late_since >= _LATE_FOR)
        if late < -_EARLY or is_set_back or stays_late:
            self._restart()
        while self._fastest[0][0] < arrival_ns - _MEMORY:
            self._fastest.popleft()
        most = int(_SLEW * min(max(stamp_ns - self._stamp_ns, 0), _LONGEST))
        self.offset_ns += min(max(self._fastest[0][1] - self.offset_ns, -most), most)
        self._stamp_ns = stamp_ns
        return self.offset_ns

    def _restart(self) -> None:
        """Begin again with the messages that do not fit the present offset."""
        self.steps += 1
        self._fastest = deque(each for each in self._fastest
                              if not -_EARLY <= each[1] - self.offset_ns <= _LATE)
        self.offset_ns, self._late_since = self._fastest[0][1], None

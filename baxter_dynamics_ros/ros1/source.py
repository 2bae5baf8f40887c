"""Statistics of one publisher's messages: lost, repeated, rate and jitter."""

import math

from .clock import ClockOffset
from .joint_state import JointState

_HALF = 2 ** 31  # half the range of sequence numbers


class Source:
    """Statistics of one publisher's messages, across reconnections."""

    def __init__(self, publisher: str) -> None:
        self.publisher = publisher
        self.clock = ClockOffset()
        self.received = 0  # number of messages
        self.lost = 0  # missing in the sequence numbers
        self.repeated = 0  # dropped
        self.arrival_ns = 0  # of the last message, by this machine's clock [ns]
        self.rate = 0.0  # over the last period [Hz]
        self.jitter = 0.0  # standard deviation of the delay over the last period [s]
        self._uri = ''
        self._seq = self._stamp_ns = 0
        self._count, self._sum, self._square = 0, 0.0, 0.0  # delays in this period [s]

    def take(self, uri: str, state: JointState, arrival_ns: int) -> bool:
        """
        Count a message with its time of arrival [ns], and return whether it is new.

        Sequence numbers restart when the URI of the publisher changes.
        """
        if uri == self._uri:
            ahead = (state.seq - self._seq) % 2 ** 32
            if ahead == 0 and state.stamp_ns == self._stamp_ns:
                self.repeated += 1
                return False
            self.lost += ahead - 1 if 1 < ahead < _HALF else 0
        self._uri, self._seq, self._stamp_ns = uri, state.seq, state.stamp_ns
        self.received += 1
        self.arrival_ns = arrival_ns
        if state.stamp_ns:
            self.clock.update(state.stamp_ns, arrival_ns)
            late = self.clock.late_ns * 1e-9
            self._sum += late
            self._square += late * late
        self._count += 1
        return True

    def close_period(self, seconds: float) -> None:
        """Compute rate and jitter of a period of ``seconds`` [s] and start the next."""
        count, mean = self._count, self._sum / max(self._count, 1)
        self.rate = count / seconds
        self.jitter = math.sqrt(max(self._square / max(count, 1) - mean * mean, 0.0))
        self._count, self._sum, self._square = 0, 0.0, 0.0

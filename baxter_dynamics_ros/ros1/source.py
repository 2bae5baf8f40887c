"""Messages of one publisher of one topic: which are new, how many are lost, how late they are."""

import math

from .clock import ClockOffset
from .joint_state import JointState

_HALF = 2 ** 31  # of the numbers that a message may have


class Source:
    """
    Counts the messages of one publisher, through all of its connections.

    Parameters
    ----------
    publisher : str
        Its name.

    Attributes
    ----------
    clock : ClockOffset
        Of the publisher's machine.
    received, lost, repeated : int
        Messages that were taken; that are missing in the sequence of the publisher's numbers; and
        that came a second time and were dropped.
    arrival_ns : int
        When the last one was taken, by this machine's clock [ns].
    rate, jitter : float
        Of the period that was closed last: messages a second [Hz], and standard deviation of
        their lateness [s].

    """

    def __init__(self, publisher: str) -> None:
        self.publisher = publisher
        self.clock = ClockOffset()
        self.received = self.lost = self.repeated = 0
        self.arrival_ns = 0
        self.rate = self.jitter = 0.0
        self._uri = ''
        self._seq = self._stamp_ns = 0
        self._count, self._sum, self._square = 0, 0.0, 0.0  # lateness of this period [s]

    def take(self, uri: str, state: JointState, arrival_ns: int) -> bool:
        """
        Take a message, and return whether it is new.

        Parameters
        ----------
        uri : str
            Of the publisher; its numbers begin anew with another.
        state : JointState
            The message.
        arrival_ns : int
            When it arrived, by this machine's clock [ns].

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
        """Begin a new period; the last took ``seconds`` [s]."""
        count, mean = self._count, self._sum / max(self._count, 1)
        self.rate = count / seconds
        self.jitter = math.sqrt(max(self._square / max(count, 1) - mean * mean, 0.0))
        self._count, self._sum, self._square = 0, 0.0, 0.0

"""Re-timing of messages stamped on arrival: even stamps from a phase-locked loop."""

from math import sqrt

from .stamp_evidence import AUTO, HEADER, RECEIPT, SHORT_STEP, StampEvidence

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


class ArrivalLine:
    """
    Line of arrival time over message number, fitted by a phase-locked loop.

    With e the difference between an arrival and the last time t of the line plus one period T, the
    line is updated by ``t += T + g e`` and ``T += h e``. At first g and h fall as 1/n and 1/n^2,
    which gives the least-squares line of n arrivals. Their lower bounds ``g = T / MEMORY`` and
    ``h = g^2 / 2`` make the time constant the same at every rate.

    Attributes
    ----------
    period : float
        T [s].
    phase : float
        t minus the newest arrival [s]; small, so that a float loses no digits.
    jitter : float
        RMS of e over the last MEMORY [s].
    locked : bool
        Whether the line can be used.

    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Start again at the newest arrival."""
        self.period = self.phase = self.jitter = 0.0
        self.locked = False
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


class Retiming:
    """
    Source of stamps for a stream of joint states: header stamps or re-timed stamps.

    Re-timed stamps lag the robot's stamps by slightly less than the mean transport delay. The line
    counts messages, so a lost message shifts it by one period for a few seconds.

    Parameters
    ----------
    mode : str
        One of :data:`.stamp_evidence.MODES`. 'header': header stamps. 'arrival': header stamps,
        re-timed because they are times of arrival. 'receipt': re-timed times of receipt. 'auto':
        selected by :class:`.stamp_evidence.StampEvidence`, starting with 'header'.

    Attributes
    ----------
    source : str
        'header', 'arrival' or 'receipt': source in use.
    restarted : bool
        Whether the last stamp returned starts a new time line.
    resyncs : int
        Number of times the line in use was restarted, since the last reset.

    """

    def __init__(self, mode: str) -> None:
        self._mode = mode
        self._line = ArrivalLine()
        self.reset()

    def reset(self) -> None:
        """Forget the stream and the evidence about its stamps."""
        self.source = HEADER if self._mode == AUTO else self._mode
        self.restarted = False
        self.resyncs = 0
        self._line.restart()
        self._evidence = StampEvidence()
        self._last: int | None = None  # stamp of the last message [ns]
        self._out: int | None = None  # stamp returned for it [ns]
        self._continues = False  # whether the next stamp continues the time line

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
        """
        Return the header stamp or time of receipt that is in use, before re-timing [ns].

        The time of receipt, if known, replaces a zero header stamp, and every header stamp if the
        source is 'receipt'.
        """
        if received_ns is not None and (stamp_ns == 0 or self.source == RECEIPT):
            return received_ns
        return stamp_ns

    def update(self, stamp_ns: int, fresh: bool, received_ns: 'int | None' = None
               ) -> 'int | None':
        """
        Process a message's stamp.

        Parameters
        ----------
        stamp_ns : int
            Header stamp [ns]; 0 means that it is not set.
        fresh : bool
            False for data of the last message or of another publisher: the step is no evidence
            about the stamps, and an equal stamp returns the last result again.
        received_ns : int, optional
            Time of receipt [ns].

        Returns
        -------
        int or None
            The stamp to use [ns]. Re-timed stamps increase until ``restarted`` is true. None while
            the line is not locked.

        """
        self.restarted = False
        if self._mode == AUTO:
            self._weigh(stamp_ns, fresh, received_ns)
        stamp_ns = self.select(stamp_ns, received_ns)
        last, self._last = self._last, stamp_ns
        if last is None:
            return None if self.retimed else self._return(stamp_ns)
        if stamp_ns == last and not fresh:
            return self._out
        fits = self._mode == HEADER or self._line.update(stamp_ns - last)
        if not self.retimed:
            return self._return(stamp_ns)
        if not fits:
            self.resyncs += self._continues
            self._continues = False
        if not self._line.locked:
            self._out = None
            return None
        even = stamp_ns + round(self._line.phase * 1e9)
        if self._out is not None and not self._continues and even <= self._out:
            return None  # the line is still behind the last header stamp returned
        return self._return(even)

    def _weigh(self, stamp_ns: int, fresh: bool, received_ns: int | None) -> None:
        """Choose the source by the evidence."""
        before = self.source
        self.source = self._evidence.update(stamp_ns, fresh, received_ns)
        if self.source != before:
            self._continues = False
            if RECEIPT in (self.source, before) and stamp_ns:  # stamps of another clock
                self._line.restart()
                self._last = self._out = None

    def _return(self, stamp_ns: int) -> int:
        self.restarted = not self._continues
        self._continues = True
        self._out = stamp_ns
        return stamp_ns

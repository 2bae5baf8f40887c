"""Even stamps for messages that are stamped on arrival, from a phase-locked loop."""

from math import sqrt

from .stamp_evidence import ARRIVAL, HEADER, RECEIPT, SHORT_STEP, StampEvidence

AUTO = 'auto'
MODES = (AUTO, HEADER, ARRIVAL, RECEIPT)

MEMORY = 2.0  # time constant of the line's phase [s]
LOCKING = 1.0  # the line is used after this time [s] ...
LOCKING_MESSAGES = 20  # ... and this number of messages
LATE = 0.02  # largest error that corrects the line [s]: most messages are on time, some very late
# A larger error of one message, or a larger mean error over ASIDE_TIME, restarts the line: there
# was a pause, or the rate or the clock has changed.
FAR = 0.25  # [s]
ASIDE = 0.05  # [s]
ASIDE_TIME = 0.5  # [s]


class ArrivalLine:
    """
    Line of arrival time over message number, fitted by a phase-locked loop.

    With e the error of an arrival against the line's last time t plus one period T, the line is
    updated by ``t += T + g e`` and ``T += h e``. At first g and h fall as 1/n and 1/n^2, which
    gives the least-squares line of n arrivals. Their lower bounds ``g = T / MEMORY`` and
    ``h = g^2 / 2`` make the time constant the same at every rate.

    Attributes
    ----------
    period : float
        T [s].
    phase : float
        t minus the newest arrival [s]: small, so that a float holds all digits.
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
        self._mean = 0.0  # of e [s]

    def update(self, step: int) -> bool:
        """
        Add an arrival, ``step`` [ns] after the last.

        Returns
        -------
        bool
            False if it does not fit the line, which restarts at it.

        """
        if self._n == 1 and 0 <= step < SHORT_STEP:
            return True  # part of a burst, delayed by an unknown time: start at its end
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
    Stamps of a stream of joint states: the headers', or re-timed ones.

    Re-timed stamps lag the robot's by somewhat less than the mean transport delay. The line counts
    messages: a lost message shifts it by a period for some seconds.

    Parameters
    ----------
    mode : str
        One of :data:`MODES`. 'header': header stamps. 'arrival': header stamps are times of
        arrival and are re-timed. 'receipt': times of receipt, re-timed. 'auto': as
        :class:`.stamp_evidence.StampEvidence` decides; 'header' at first.

    Attributes
    ----------
    source : str
        'header', 'arrival' or 'receipt': what stamps are made from now.
    restarted : bool
        Whether the last stamp returned starts a new time line.
    resyncs : int
        Number of times that arrivals left the line in use, since the last reset.

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
        """RMS of arrivals minus re-timed stamps over the last seconds [s], or None."""
        return self._line.jitter if self.retimed and self._line.locked else None

    def select(self, stamp_ns: int, received_ns: 'int | None') -> int:
        """
        Return the stamp in use before it is re-timed [ns].

        The time of receipt, if known, replaces a header stamp that is not set (0), and all header
        stamps if the source is 'receipt'.
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
            Header stamp [ns].
        fresh : bool
            False for data of the last message or of another publisher: the step to it is no
            evidence, and at an equal stamp the last one is returned again.
        received_ns : int, optional
            Time of receipt [ns].

        Returns
        -------
        int or None
            The stamp to use [ns]. Re-timed ones increase until ``restarted`` is true; None while
            there is no line to take them from.

        """
        self.restarted = False
        before = self.source
        if self._mode == AUTO:
            self.source = self._evidence.update(stamp_ns, fresh, received_ns)
        if self.source != before:
            self._continues = False
            if RECEIPT in (self.source, before) and stamp_ns:  # stamps of another clock
                self._line.restart()
                self._last = self._out = None
        stamp_ns = self.select(stamp_ns, received_ns)
        if self._last is None:
            self._last = stamp_ns
            return None if self.retimed else self._return(stamp_ns)
        step = stamp_ns - self._last
        if step == 0 and not fresh:
            return self._out
        self._last = stamp_ns
        if self._mode == HEADER:
            return self._return(stamp_ns)
        fits = self._line.update(step)
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
            return None  # the line is behind the last header stamp that was returned
        return self._return(even)

    def _return(self, stamp_ns: int) -> int:
        self.restarted = not self._continues
        self._continues = True
        self._out = stamp_ns
        return stamp_ns

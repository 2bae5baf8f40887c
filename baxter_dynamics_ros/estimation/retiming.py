"""Even stamps in the place of times of arrival: recognises those, and fits a line to them."""

from collections import deque
from math import sqrt

MODES = ('auto', 'header', 'arrival')

# The robot publishes at 800 Hz at most: new data that come sooner after the last are stamped with
# their time of arrival. So many of them among so many messages are no accident.
BUNCHED = 500_000  # [ns]
ENOUGH = 3
AMONG = 100

MEMORY = 2.0  # time constant of the line's phase [s]
LOCKING = 1.0  # the line must have run so long [s] ...
LOCKING_MESSAGES = 20  # ... and through so many arrivals before it is used
LATE = 0.02  # later ones pull the line no more than this [s]: most come in time, some very late
# An arrival further off, or arrivals that are further off in the mean over ASIDE_TIME, are not of
# this line: there was a pause, or the rate or the clock was changed.
FAR = 0.25  # [s]
ASIDE = 0.05  # [s]
ASIDE_TIME = 0.5  # [s]


class ArrivalLine:
    """
    The line through the times of arrival over the messages' number: a phase-locked loop.

    With e the error of an arrival against the line's last time t one period T on, the line moves
    by ``t += T + g e`` and ``T += h e``. At first g and h fall as 1/n and 1/n^2, such that the
    line is the least-squares line of n arrivals. They stop at ``g = T / MEMORY`` and
    ``h = g^2 / 2``, which forget in the same time at every rate.

    Attributes
    ----------
    period : float
        T [s].
    phase : float
        t less the newest arrival [s]: small, so that no digits of a stamp are lost.
    jitter : float
        RMS of e over the last MEMORY [s].
    locked : bool
        Whether the line can be used.

    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Begin with the newest arrival."""
        self.period = self.phase = self.jitter = 0.0
        self.locked = False
        self._n = 1
        self._mean = 0.0  # of e [s]

    def update(self, step: int) -> bool:
        """
        Take an arrival, ``step`` [ns] after the last.

        Returns
        -------
        bool
            False where it does not belong to the line, which begins anew with it.

        """
        if self._n == 1 and 0 <= step < BUNCHED:
            return True  # they waited, who knows how long: begin with the last of them
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
    Decides which stamps a stream of joint states has: the headers', or even ones.

    Re-timed stamps lag the robot's own by what messages are on their way, somewhat less than the
    mean. The line counts messages: one that is lost shifts it by a period, for some seconds.

    Parameters
    ----------
    mode : str
        One of :data:`MODES`. 'header': the headers' stamps are believed. 'arrival': they are times
        of arrival and re-timed. 'auto': they are believed until new data came less than 0.5 ms
        after the last three times among 100 messages, and re-timed from then on.

    Attributes
    ----------
    retimed : bool
        Whether stamps are re-timed now, or withheld until they can be.
    restarted : bool
        Whether the last stamp that was returned begins a new time line.
    resyncs : int
        How often arrivals left the line that was in use, since the last reset.

    """

    def __init__(self, mode: str) -> None:
        self._mode = mode
        self._line = ArrivalLine()
        # Numbers of the messages that came too soon.
        self._bunched: deque[int] = deque(maxlen=ENOUGH)
        self.reset()

    def reset(self) -> None:
        """Forget the stream, and what its stamps were recognised to be."""
        self.retimed = self._mode == 'arrival'
        self.restarted = False
        self.resyncs = 0
        self._line.restart()
        self._bunched.clear()
        self._n = 0
        self._last: int | None = None  # stamp of the last message [ns]
        self._out: int | None = None  # what was returned for it [ns]
        self._continues = False  # whether the next stamp continues those that were returned

    @property
    def period(self) -> 'float | None':
        """Time between two re-timed stamps [s]; None where there are none."""
        return self._line.period if self.retimed and self._line.locked else None

    @property
    def jitter(self) -> 'float | None':
        """RMS of arrivals less re-timed stamps over the last seconds [s]; None without."""
        return self._line.jitter if self.retimed and self._line.locked else None

    def update(self, stamp_ns: int, fresh: bool) -> 'int | None':
        """
        Take a message's stamp.

        Parameters
        ----------
        stamp_ns : int
            The header's [ns].
        fresh : bool
            False where the data are those of the last message, or another publisher's: then how
            soon it came tells nothing, and at an equal stamp the last one is returned again.

        Returns
        -------
        int or None
            The stamp to use [ns]. Re-timed ones increase until ``restarted`` is true; None while
            there is no line to take them from.

        """
        self.restarted = False
        if self._last is None:
            self._last = stamp_ns
            return None if self.retimed else self._hand_out(stamp_ns)
        step = stamp_ns - self._last
        if step == 0 and not fresh:
            return self._out
        self._last = stamp_ns
        if self._mode == 'header':
            return self._hand_out(stamp_ns)
        stays = self._line.update(step)
        if not self.retimed:
            if not (fresh and self._is_arrival(step)):
                return self._hand_out(stamp_ns)
            self.retimed, self._continues = True, False
        if not stays:
            self.resyncs += self._continues
            self._continues = False
        if not self._line.locked:
            self._out = None
            return None
        even = stamp_ns + round(self._line.phase * 1e9)
        if self._out is not None and not self._continues and even <= self._out:
            return None  # the line is behind the last stamp that was believed
        return self._hand_out(even)

    def _is_arrival(self, step: int) -> bool:
        """Tell whether this step [ns] shows that stamps are times of arrival."""
        self._n += 1
        if not 0 <= step < BUNCHED:
            return False
        self._bunched.append(self._n)
        return len(self._bunched) == ENOUGH and self._n - self._bunched[0] < AMONG

    def _hand_out(self, stamp_ns: int) -> int:
        self.restarted = not self._continues
        self._continues = True
        self._out = stamp_ns
        return stamp_ns

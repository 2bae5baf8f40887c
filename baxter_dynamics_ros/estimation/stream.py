"""The door: joint states in, the samples of one arm out, on an even time line; all counted."""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from .continuity import Continuity, UNKNOWN_PERIOD
from .events import DROPPED, Event, RESETS
from .joint_selection import Intake
from .retiming import Retiming
from ..model.arrays import Array


class State(NamedTuple):
    """The arm's state as last measured; arrays (7,) in joint order."""

    stamp_ns: int  # the header's, or re-timed [ns]
    q: Array  # [rad]
    qd: 'Array | None'  # [rad/s]
    effort: 'Array | None'  # [N m]; None where there is none, or none that is valid


class Sample(NamedTuple):
    """A state that is part of the stream, and how it continues it."""

    state: State
    dt: float  # since the sample before [s]; of no meaning where the stream begins
    begins: bool  # nothing before it belongs to the same motion


class Stream:
    """
    Takes joint states, and hands on those of one arm that belong to one motion.

    Parameters
    ----------
    side : str
        'right' or 'left'.
    stamps : str
        One of :data:`.retiming.MODES`: what the messages' stamps are.

    Attributes
    ----------
    counts : Counter
        How often each :class:`Event` occurred; under 'received' all messages, under 'taken' those
        that were not dropped.
    latest : State or None
        The newest measured state.
    clock : Retiming
        Makes the stamps that are used.
    begins : bool
        Whether the next sample will be the first of its motion.

    """

    def __init__(self, side: str, stamps: str) -> None:
        self.intake = Intake(side)
        self.counts: Counter[Event | str] = Counter()
        self.latest: State | None = None
        self.clock = Retiming(stamps)
        self._continuity = Continuity()
        self.begins = True

    def reset(self, stamps: str | None = None) -> None:
        """Forget the stream, the counts stay; from now on stamps are as given, if they are."""
        self.counts[Event.RESET_REQUESTED] += 1
        if stamps is not None:
            self.clock = Retiming(stamps)
        self.clock.reset()
        self._continuity.forget()
        self.begins = True

    def take(self, stamp_ns: int, names: Sequence[str], position: Array, velocity: Array,
             effort: Array) -> 'Sample | State | Event':
        """
        Take a joint state, given as to :meth:`.predictor.Predictor.handle`.

        Returns
        -------
        Sample, State or Event
            The reason where the message is dropped; the state alone while the period of re-timed
            stamps is not known.

        """
        self.counts['received'] += 1
        reading = self.intake.read(names, position, velocity, effort)
        if isinstance(reading, Event):
            self.counts[reading] += 1
            return reading
        q, qd, measured = reading
        period = self.clock.period or (UNKNOWN_PERIOD if self.clock.retimed else None)
        verdict = self._continuity.judge(stamp_ns, q, qd, measured, period)
        if verdict is not None and not (verdict is Event.REPEATED_STAMP and self.clock.retimed):
            self.counts[verdict] += 1
            if verdict in DROPPED:
                return verdict
            self.begins = self.begins or verdict in RESETS
        self.counts['taken'] += 1
        if qd is None:
            self.counts[Event.VELOCITY_MISSING] += 1
        # What another publisher sends right after the robot says nothing of the robot's stamps.
        tells = not self._continuity.repeated and verdict is not Event.RESET_POSITION_JUMP
        return self._sample(stamp_ns, tells, q, qd, self._valid(measured))

    def _sample(self, stamp_ns: int, tells: bool, q: Array, qd: Array | None,
                effort: Array | None) -> Sample | State:
        """Return the sample at its time on the stream's own line, or the state alone."""
        clock = self.clock
        before = clock.retimed, clock.resyncs
        time_ns = clock.update(stamp_ns, tells)
        if (clock.retimed, clock.resyncs) != before:
            self.counts[Event.RESET_RESYNC if before[0] else Event.RESET_RETIMED] += 1
        if time_ns is None:
            self.latest = state = State(stamp_ns, q, qd, effort)
            self.begins = True
            return state
        self.begins = self.begins or clock.restarted
        last = self.latest
        dt = 0.0 if self.begins or last is None else (time_ns - last.stamp_ns) * 1e-9
        self.latest = State(time_ns, q, qd, effort)
        sample = Sample(self.latest, dt, self.begins)
        self.begins = False
        return sample

    def _valid(self, effort: Array | None) -> Array | None:
        """Return the measured effort, or None where the robot cannot have measured it."""
        if effort is None:
            self.counts[Event.EFFORT_MISSING] += 1
        elif not any(effort.tolist()):
            self.counts[Event.EFFORT_ALL_ZERO] += 1
            return None
        return effort

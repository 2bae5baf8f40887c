"""Data of a fit: motions estimated from recordings, and their checks."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..estimation.events import Event
from ..estimation.predictor import Predictor
from ..estimation.settings import EffortModelSettings, PredictorSettings
from ..model import Array, BaxterDynamicsError, Bools, N_JOINTS, names_of, Presliding
from ..recordings.data_check import DataCheck, event_notices, Notice, RunningCheck
from ..recordings.playback import joined, play, Samples, segments
from ..recordings.recording import Recording

_SHORT = 1.0  # minimum duration of a recording [s]
_SHORTEST = 10.0  # ... of all recordings together [s]
_MOVES = 0.05  # minimum speed of a moving joint [rad/s]
_SPEED_SPAN = 0.1  # half span of the position difference that gives the speed [s]


class CalibrationError(BaxterDynamicsError):
    """The recordings cannot be used for a calibration."""


@dataclass(frozen=True, eq=False)
class Motion(Samples):
    """Samples of a recording, and quantities derived from them."""

    name: str
    counts: Counter[Any] = field(default_factory=Counter)  # counts of the stream handler

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def segments(self) -> list[slice]:
        """Slices between restarts of the filter."""
        return segments(self.time) if len(self) else []

    @cached_property
    def duration(self) -> float:
        """Time covered by the estimates, without gaps [s]."""
        return float(sum(np.ptp(self.time[rows]) for rows in self.segments))

    @property
    def period(self) -> float:
        """Typical time between two estimates [s]."""
        return float(np.median(np.diff(self.time)))

    def presliding(self, length: float) -> Array:
        """Return Dahl's state (n, 7) for an angle over which friction reverses [rad]."""
        if length not in self._presliding:
            states = []
            for segment in self.segments:
                state = Presliding(length)
                states += [state.update(q) for q in self.q[segment]]
            self._presliding[length] = np.array(states)
        return self._presliding[length]

    @cached_property
    def _presliding(self) -> dict[float, Array]:
        """States so far, by length: every fit needs the same."""
        return {}


def observe(recording: Recording, settings: PredictorSettings) -> Motion:
    """Return a recording's motion, estimated with the filter of some settings."""
    predictor = Predictor(replace(
        settings, arm=recording.arm, align=True, effort_model=EffortModelSettings(enabled=False)))
    samples = joined([part.take(np.isfinite(part.effort[:, 0]))
                      for part in play(recording, predictor)])
    return Motion(**vars(samples), name=recording.name, counts=Counter(predictor.counts))


def residual(motion: Motion, settings: PredictorSettings) -> Array:
    """Return the residual of a motion (n, 7) [N m], computed by the predictor."""
    model = settings.model.effort_model
    dahl = motion.presliding(model.dahl_length) if model.dahl.any() else np.zeros(motion.q.shape)
    result = Predictor(settings).predict(replace(motion, dahl=dahl).estimate).residual
    assert result is not None  # for the effort was measured
    return result


def turning(motions: list[Motion]) -> Bools:
    """Return the joints whose positions move in both directions, (7,) bool."""
    lowest, highest = _speeds(motions)
    return (highest > _MOVES) & (lowest < -_MOVES)


def _speeds(motions: list[Motion]) -> Array:
    """
    Return the lowest and the highest speed of each joint, from positions alone, (2, 7) [rad/s].

    Measured velocities have a noise of 0.1 rad/s on some arms, this speed one of 0.003 rad/s.
    """
    speeds = [np.zeros((1, N_JOINTS))]
    for motion in motions:
        for segment in motion.segments:
            t, q = motion.time[segment], motion.q[segment]
            k = max(round(_SPEED_SPAN / motion.period), 1) if len(t) > 1 else 1
            speeds.append((q[2 * k:] - q[:-2 * k]) / (t[2 * k:] - t[:-2 * k])[:, None])
    every = np.concatenate(speeds)
    return np.stack([every.min(0), every.max(0)])


def long_enough(motions: list[Motion]) -> list[Motion]:
    """Return the motions that are long enough to be fitted."""
    return [motion for motion in motions if motion.duration >= _SHORT]


def distinct(motions: list[Motion]) -> tuple[list[Motion], list[Notice]]:
    """Return each measurement once, and a notice for each recording that was given twice."""
    kept: list[Motion] = []
    notices = []
    for motion in motions:
        same = [one.name for one in kept if len(one) and np.array_equal(one.q, motion.q)
                and np.array_equal(one.effort, motion.effort)]
        if same:
            notices.append(Notice('duplicate', f'holds the same data as {same[0]}: counted once',
                                  recording=motion.name))
        else:
            kept.append(motion)
    return kept, notices


def _refuse(motions: list[Motion]) -> None:
    """Raise CalibrationError with the reason if the data cannot be fitted."""
    counts: Counter[Any] = sum((motion.counts for motion in motions), Counter())
    taken = counts['taken']
    for notice in event_notices(counts):
        if notice.refuses:
            raise CalibrationError(str(notice))
    if not taken:
        raise CalibrationError('no valid joint states of the arm: evaluate reports the reason')
    for event in (Event.EFFORT_ALL_ZERO, Event.EFFORT_MISSING):
        if counts[event] > 0.5 * taken:
            raise CalibrationError(f'{counts[event]} of {taken} joint states have no valid effort '
                                   f'({event.remedy}): there is nothing to fit to')
    duration = sum(motion.duration for motion in long_enough(motions))
    if duration < _SHORTEST:
        raise CalibrationError(f'{duration:.1f} s of motion are too short: expected at least '
                               f'{_SHORTEST:g} s in recordings of {_SHORT:g} s or more, '
                               'preferably a minute (--plan writes one)')
    fastest = np.abs(_speeds(motions)).max(0)
    if (fastest < _MOVES).all():
        raise CalibrationError(f'no joint moves faster than {fastest.max():.3f} rad/s: record a '
                               'motion that moves every joint back and forth (--plan writes one)')


def check_data(motions: list[Motion], settings: PredictorSettings) -> DataCheck:
    """Return the check of the data; raise CalibrationError if they cannot be fitted."""
    _refuse(motions)
    running = RunningCheck(settings)
    for motion in long_enough(motions):
        running.add(motion)
    check = running.result()
    assert check is not None  # they are long enough
    if reasons := [str(problem) for problem in check.problems if problem.refuses]:
        raise CalibrationError('; '.join(reasons))
    return check


def warnings(motions: list[Motion]) -> Iterator[Notice]:
    """Yield warnings about the recordings."""
    moving = np.abs(_speeds(motions)).max(0) > _MOVES
    for kind, which, what in (
            ('still', ~moving, f'never moves faster than {_MOVES:g} rad/s'),
            ('one_way', moving & ~turning(motions), 'moves in one direction only')):
        if which.any():
            joints = names_of(which)
            yield Notice(kind, f'{", ".join(joints)}: {what}', joints)
    for motion in motions:
        if motion.duration < _SHORT:
            yield Notice('short', f'{motion.duration:.1f} s of motion are too short: left out',
                         recording=motion.name)
        yield from event_notices(motion.counts, motion.name)

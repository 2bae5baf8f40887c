"""Recordings that cannot be fitted to are refused, with the reason; others get warnings."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .fit_data import Motion
from .identifiability import MOVES, turning
from ..estimation.events import Event, REMEDIES
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import JOINTS
from ..recordings.playback import Recording

_SHORT = 1.0  # a recording that is shorter is left out [s]
SHORTEST = 10.0  # recordings' length together, below which nothing can be fitted [s]


class CalibrationError(BaxterDynamicsError):
    """The recordings cannot be used for a calibration."""


def one_arm(recordings: Sequence[Recording]) -> str:
    """Return the arm that all recordings are of; refuse if they differ."""
    if not recordings:
        raise CalibrationError('no recordings')
    arms = sorted({recording.arm for recording in recordings})
    if len(arms) > 1:
        raise CalibrationError(
            'the recordings are of both arms: calibrate one arm at a time (--arm)')
    return arms[0]


def long_enough(motions: list[Motion]) -> list[Motion]:
    """Return the motions that are long enough to say anything."""
    return [motion for motion in motions if motion.duration >= _SHORT]


def refuse(motions: list[Motion]) -> None:
    """Refuse what cannot be fitted to, with the reason."""
    counts: dict[Any, int] = {}
    for motion in motions:
        for event, n in motion.counts.items():
            counts[event] = counts.get(event, 0) + n
    taken = counts.get('taken', 0)
    if not taken:
        raise CalibrationError('no valid joint states of the arm: evaluate says what is wrong')
    for event in (Event.EFFORT_ALL_ZERO, Event.EFFORT_MISSING):
        if counts.get(event, 0) > 0.5 * taken:
            raise CalibrationError(f'{counts[event]} of {taken} joint states have no valid effort '
                                   f'({REMEDIES[event]}): there is nothing to fit to')
    duration = sum(motion.duration for motion in long_enough(motions))
    if duration < SHORTEST:
        raise CalibrationError(f'{duration:.1f} s of motion are too short: expected at least '
                               f'{SHORTEST:g} s, better a minute (--plan shows one)')
    fastest = np.max([np.abs(motion.qd).max(0) for motion in motions if len(motion)], axis=0)
    if (fastest < MOVES).all():
        raise CalibrationError(f'no joint moves faster than {fastest.max():.3f} rad/s: record a '
                               'motion that turns every joint round (--plan shows one)')


def warnings(motions: list[Motion]) -> Iterator[str]:
    """Yield what a reader should know of the recordings, a line each."""
    moving = np.abs(np.concatenate([motion.qd for motion in motions])).max(0) > MOVES
    for which, what in ((~moving, f'never moves faster than {MOVES:g} rad/s'),
                        (moving & ~turning(motions), 'turns one way only')):
        if which.any():
            yield f'{", ".join(JOINTS[i] for i in np.flatnonzero(which))}: {what}'
    for motion in motions:
        if motion.duration < _SHORT:
            yield f'{motion.name}: {motion.duration:.1f} s of motion are too short: left out'
        for event, remedy in REMEDIES.items():
            if motion.counts.get(event):
                yield f'{motion.name}: {motion.counts[event]} x {event.value}: {remedy}'

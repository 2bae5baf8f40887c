"""Recordings that cannot be fitted to are refused, with the reason; others get warnings."""

import numpy as np

from ..core.exceptions import BaxterDynamicsError
from ..core.joints import JOINTS
from ..signals.events import Event
from ..signals.events import REMEDIES

SHORTEST = 10.0  # recordings' length together, below which nothing can be fitted [s]
_MOVES = 0.05  # a joint that never exceeds this speed does not move [rad/s]


class CalibrationError(BaxterDynamicsError):
    """The recordings cannot be used for a calibration."""


def one_arm(recordings) -> str:
    """Return the arm that all recordings are of; refuse if they differ."""
    if not recordings:
        raise CalibrationError('no recordings')
    arms = sorted({recording.arm for recording in recordings})
    if len(arms) > 1:
        raise CalibrationError(
            'the recordings are of both arms: calibrate one arm at a time (--arm)')
    return arms[0]


def refuse(motions: list):
    """Refuse what cannot be fitted to, with the reason."""
    counts = {}
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
    duration = sum(motion.duration for motion in motions)
    if duration < SHORTEST:
        raise CalibrationError(f'{duration:.1f} s of motion are too short: expected at least '
                               f'{SHORTEST:g} s, better a minute (--plan shows one)')
    fastest = np.max([np.abs(motion.qd).max(0) for motion in motions if len(motion)], axis=0)
    if (fastest < _MOVES).all():
        raise CalibrationError(f'no joint moves faster than {fastest.max():.3f} rad/s: record a '
                               'motion that turns every joint round (--plan shows one)')


def warnings(motions: list):
    """Yield what a reader should know of the recordings, a line each."""
    still = [joint for i, joint in enumerate(JOINTS)
             if max(np.abs(motion.qd[:, i]).max() for motion in motions) < _MOVES]
    if still:
        yield f'{", ".join(still)}: never moves faster than {_MOVES:g} rad/s'
    for motion in motions:
        for event, remedy in REMEDIES.items():
            if motion.counts.get(event):
                yield f'{motion.name}: {motion.counts[event]} x {event.value}: {remedy}'

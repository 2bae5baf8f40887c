"""Checks of recordings before a fit."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .fit_data import Motion, MOVES, turning
from ..estimation.events import Event, REMEDIES
from ..estimation.settings import PredictorSettings
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import JOINTS
from ..recordings.data_check import DataCheck, DataChecker
from ..recordings.notices import Notice
from ..recordings.recording import Recording

_SHORT = 1.0  # minimum duration of a recording [s]
SHORTEST = 10.0  # minimum duration of all recordings together [s]


class CalibrationError(BaxterDynamicsError):
    """The recordings cannot be used for a calibration."""


def one_arm(recordings: Sequence[Recording]) -> str:
    """Return the arm of all recordings; raise CalibrationError if they differ."""
    if not recordings:
        raise CalibrationError('no recordings')
    arms = sorted({recording.arm for recording in recordings})
    if len(arms) > 1:
        raise CalibrationError(
            'the recordings are of both arms: calibrate one arm at a time (--arm)')
    return arms[0]


def long_enough(motions: list[Motion]) -> list[Motion]:
    """Return the motions that are long enough to be fitted."""
    return [motion for motion in motions if motion.duration >= _SHORT]


def distinct(motions: list[Motion]) -> tuple[list[Motion], list[Notice]]:
    """Return each measurement once, and a notice for each recording that was given twice."""
    kept: list[Motion] = []
    notices = []
    for motion in motions:
        same = next((one for one in kept if len(one) and np.array_equal(one.q, motion.q)
                     and np.array_equal(one.effort, motion.effort)), None)
        if same is None:
            kept.append(motion)
        else:
            notices.append(Notice('duplicate', f'holds the same data as {same.name}: counted once',
                                  recording=motion.name))
    return kept, notices


def refuse(motions: list[Motion]) -> None:
    """Raise CalibrationError with the reason if the data cannot be fitted."""
    counts: Counter[Any] = sum((Counter(motion.counts) for motion in motions), Counter())
    taken = counts['taken']
    if counts[Event.IMPLAUSIBLE] > taken:
        raise CalibrationError(f'{counts[Event.IMPLAUSIBLE]} of {counts["received"]} joint states '
                               f'hold {REMEDIES[Event.IMPLAUSIBLE]}')
    if not taken:
        raise CalibrationError('no valid joint states of the arm: evaluate says what is wrong')
    for event in (Event.EFFORT_ALL_ZERO, Event.EFFORT_MISSING):
        if counts[event] > 0.5 * taken:
            raise CalibrationError(f'{counts[event]} of {taken} joint states have no valid effort '
                                   f'({REMEDIES[event]}): there is nothing to fit to')
    duration = sum(motion.duration for motion in long_enough(motions))
    if duration < SHORTEST:
        raise CalibrationError(f'{duration:.1f} s of motion are too short: expected at least '
                               f'{SHORTEST:g} s, better a minute (--plan shows one)')
    fastest = _fastest(motions)
    if (fastest < MOVES).all():
        raise CalibrationError(f'no joint moves faster than {fastest.max():.3f} rad/s: record a '
                               'motion that turns every joint round (--plan shows one)')


def check_data(motions: list[Motion], settings: PredictorSettings) -> 'DataCheck | None':
    """Return the check of the data; raise CalibrationError if they contradict the model."""
    checker = DataChecker(settings)
    for motion in motions:
        checker.add(motion.time, np.stack([motion.q, motion.qd, motion.qdd, motion.effort], 1),
                    motion.newest_q, motion.newest_qd)
        checker.end_recording()
    check = checker.result()
    if check is not None:
        reasons = [problem.text for problem in check.problems if problem.refuses]
        if reasons:
            raise CalibrationError('; '.join(reasons))
    return check


def warnings(motions: list[Motion]) -> Iterator[Notice]:
    """Yield warnings about the recordings."""
    moving = _fastest(motions) > MOVES
    for kind, which, what in (
            ('still', ~moving, f'never moves faster than {MOVES:g} rad/s'),
            ('one_way', moving & ~turning(motions), 'turns one way only')):
        if which.any():
            joints = tuple(JOINTS[i] for i in np.flatnonzero(which))
            yield Notice(kind, f'{", ".join(joints)}: {what}', joints)
    for motion in motions:
        if motion.duration < _SHORT:
            yield Notice('short', f'{motion.duration:.1f} s of motion are too short: left out',
                         recording=motion.name)
        for event, remedy in REMEDIES.items():
            if motion.counts.get(event):
                yield Notice(event.value, f'{motion.counts[event]} x {event.value}: {remedy}',
                             recording=motion.name)


def _fastest(motions: list[Motion]) -> Any:
    return np.max([np.abs(motion.speed).max(0) for motion in motions if len(motion)], axis=0)

"""What is said of an arm in words: contact, rates, delays, and why there is no residual."""

from __future__ import annotations

import math

from .watch_data import ArmData, Watched
from ..model.joints import JOINTS

LEVELS = ('OK', 'WARN', 'ERROR', 'STALE')


def contact(arm: ArmData, now: float) -> str:
    """Return whether something touches the arm, where and since when."""
    if not arm.contact_is_live(now):
        return f'contact unknown, nothing heard{_for(now - arm.contact_heard)}'
    if not arm.contact:
        return 'no contact'
    joints = ', '.join(arm.joints_in_contact()) or 'joints not known yet'
    least = '' if arm.saw_it_begin else 'at least '
    return f'CONTACT at {joints} for {least}{age(now - arm.contact_since)}'


def rates(watched: Watched, arm: ArmData, now: float) -> str:
    """Return the rates, and how far the newest residual is behind the newest joint state."""
    measured = watched.inputs.get(arm.side)
    rate = measured.rate(now) if measured is not None else 0.0
    words = [f'{arm.predicted.rate(now):.1f} predictions/s',
             f'{rate:.1f} joint states/s' if rate else 'no joint states heard (--topic)']
    if arm.residual.is_live(now):
        words.append(f'residual {age(arm.residual.age(now))} old')
        if measured is not None and measured.is_live(now):
            delay = (measured.stamp_ns - arm.residual.stamp_ns) * 1e-6  # [ms]
            if 0.0 <= delay < 10_000.0:  # otherwise they are of different clocks
                words[-1] = f'residual {delay:.0f} ms behind, ' + words[-1].split(' ', 1)[1]
    return ', '.join(words)


def why_no_residual(watched: Watched, arm: ArmData, now: float) -> str:
    """Return why there is no residual now."""
    if not arm.predicted.is_live(now):
        if arm.predicted.heard == -math.inf:
            return 'no prediction yet'
        return f'STALE: no prediction{_for(arm.predicted.age(now))}'
    if _lacks_effort(watched, arm, now):
        return 'no measured effort, so no residual'
    return f'no residual{_for(arm.residual.age(now))}'


def summary(watched: Watched, arm: ArmData, now: float) -> str:
    """Return one line that says how an arm is."""
    words = [contact(arm, now)]
    instant = arm.instant()
    if instant is None or not arm.residual.is_live(now):
        words.append(why_no_residual(watched, arm, now))
    else:
        words.append('residual [N m] ' + ' '.join(
            f'{joint} {value:+.2f}' for joint, value in zip(JOINTS, instant[2])))
    words.append(rates(watched, arm, now))
    if arm.statuses:
        words.append(', '.join(
            f'{name} {level_word(status.level)}' for name, status in arm.statuses.items()
            if status.level) or 'diagnostics OK')
    return f'{arm.side} arm: ' + '; '.join(words)


def level_word(level: int) -> str:
    """Return the word for a level of the diagnostics."""
    return LEVELS[level] if 0 <= level < len(LEVELS) else f'level {level}'


def age(seconds: float) -> str:
    """Return a time in words."""
    return f'{seconds:.1f} s' if seconds < 100.0 else f'{seconds / 60.0:.0f} min'


def _for(seconds: float) -> str:
    return ' yet' if math.isinf(seconds) else f' for {age(seconds)}'


def _lacks_effort(watched: Watched, arm: ArmData, now: float) -> bool:
    measured = watched.inputs.get(arm.side)
    status = arm.statuses.get('effort')
    return (measured is not None and measured.is_live(now) and measured.values is None
            or status is not None and status.values.get('valid') == 'False')

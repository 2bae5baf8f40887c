"""The calibration report: a page with findings, figures and tables."""

import math
from pathlib import Path
import shlex

import numpy as np

from . import calibration_contents as contents
from .calibration_contents import MEANINGS, parameter_name, term_name, unit_name
from .drawing import styled
from .page import change, findings, listed, number, plus_minus, render, torque
from ..calibration.calibrate_robot import sweep
from ..calibration.calibration_results import Calibration
from ..files import write_file
from ..model import JOINTS
from ..recordings.data_check import USUAL_LAG

_SAME = 0.005  # relative difference below which residuals are equal
_WORSE = 0.02  # relative increase from which a single recording is called worse
_FEW = 3  # recordings, below which one more helps much
_NAMED = 5  # parameters that are named; the others are counted


def write_calibration(path: str | Path, calibration: Calibration, command: str,
                      parameters: str) -> None:
    """
    Write the .html file, whole or not at all; raise BaxterDynamicsError if it cannot be written.

    ``parameters`` is the name of the parameter file.
    """
    # Notices about all recordings before those about one.
    notices = sorted(calibration.notices, key=lambda notice: bool(notice.recording))
    with styled():
        page = render(
            'calibration.html.j2', calibration=calibration, warnings=list(map(str, notices)),
            findings=findings(RULES, calibration), contents=contents,
            meanings={term_name(step.term): MEANINGS[step.term] for step in calibration.steps[1:]},
            command=command, parameters=parameters, file=shlex.quote(parameters))
    write_file(path, page)


def _gain(calibration: Calibration) -> str:
    before, after = calibration.total.before, calibration.total.after
    better, worse = after < (1 - _SAME) * before, after > (1 + _SAME) * before
    changes = [f'{joint}\u00a0{change(*pair)}' for joint, *pair in zip(JOINTS, before, after)]
    if better.all():
        text = f'smaller at every joint: {", ".join(changes)}'
    elif better.any():
        text = f'smaller at {listed(better, changes)}, and not at {listed(~better, changes)}'
    elif worse.any():
        text = f'smaller at no joint: {", ".join(changes)}. Keep your present parameters'
    else:
        text = 'unchanged at every joint'
    return f'On {calibration.left_out}, the residual is {text}.'


def _worse(calibration: Calibration) -> 'str | None':
    judged = calibration.judged
    ratio = np.array([one.after / np.maximum(one.before, 1e-9) for one in judged])  # (n, 7)
    worse = ratio > 1 + _WORSE
    if not worse.any():
        return None
    n, joint = np.unravel_index(np.argmax(ratio), ratio.shape)
    return (f'{worse.any(1).sum()} of {len(judged)} {calibration.fold}s, at '
            f'{listed(np.any(worse, 0))}; largest increase: {JOINTS[joint]} in {judged[n].name}, '
            f'{number(judged[n].before[joint], 2)} before, {torque(judged[n].after[joint])} '
            'after.')


def _contact(calibration: Calibration) -> 'str | None':
    if not calibration.contacts:
        return None
    total, touched = calibration.total, {contact.joint for contact in calibration.contacts}
    errors = ', '.join(f'{joint} {torque(free)} without it and {torque(touching)} with it'
                       for joint, free, touching in zip(JOINTS, total.after, total.with_contact)
                       if joint in touched)
    return (f'{"; ".join(map(str, calibration.contacts))}. It is left out of the fit and of the '
            f'errors on this page: {errors}.')


def _trust(calibration: Calibration) -> str:
    n = len(calibration.judged)
    if calibration.fold == 'part':
        return (f'There is one recording. Each of its {n} parts was predicted by a fit to the '
                'others. If the motion repeats, the parts are alike, and the result looks better '
                'than it would on another motion.')
    return (f'Each of {n} recordings was predicted by a fit to the other{"s" if n > 2 else ""}. '
            'Expect these residuals for a new motion that differs from the recordings as much as '
            'they differ from each other.')


def _uncertain(calibration: Calibration) -> 'str | None':
    loose = [f'{parameter_name(one)} ({plus_minus(one.value, one.deviation, unit_name(one.unit))})'
             for one in calibration.parameters
             if one.term != 'inertial' and one.deviation > abs(one.value)]
    if not loose:
        return None
    more = f' and {len(loose) - _NAMED} more' if len(loose) > _NAMED else ''
    return (f'{", ".join(loose[:_NAMED])}{more}: the standard deviation is larger than the '
            'value. Do not read these as properties of the robot.')


def _record_next(calibration: Calibration) -> 'str | None':
    wishes = []
    if calibration.fold == 'part' or len(calibration.judged) < _FEW:
        wishes.append('another recording of a different motion')
    lower, upper = calibration.after.effort_model.spring_range
    low, high, is_wide = sweep(calibration.s1_range, calibration.after.effort_model)
    if calibration.after.effort_model.enabled and not is_wide:
        wishes.append(f'a motion of s1 from {number(lower, 1)} to {number(upper, 1)} rad, for the '
                      f'spring (now {number(low, 2)} to {number(high, 2)})')
    if any(notice.kind in ('unidentifiable', 'still') for notice in calibration.notices):
        wishes.append('a motion in which the joints named in the warnings move back and forth')
    return f'Useful: {"; ".join(wishes)}. See the last command of this page.' if wishes else None


def _lag(calibration: Calibration) -> str:
    used = f'{number(1e3 * calibration.after.acceleration.velocity_lag, 1)}\u00a0ms'
    lag = calibration.lag
    if lag is None:
        return f'Not measured, because no joint moves or velocity is missing. Used: {used}.'
    text = (f'{plus_minus(1e3 * lag.value, 1e3 * lag.uncertainty, "ms")} measured, {used} used; '
            f'{number(1e3 * USUAL_LAG, 0)}\u00a0ms are usual on Baxter.')
    odd = np.abs(lag.per_joint - lag.value) > 0.003  # false where NaN
    joints = [f'{joint} ({number(1e3 * value, 1)}\u00a0ms)'
              for joint, value in zip(JOINTS, lag.per_joint)]
    return text + (f' Joints that differ: {listed(odd, joints)}.' if odd.any() else '')


def _tilt(calibration: Calibration) -> 'str | None':
    fitted = {one.component: one for one in calibration.of_term('tilt')}
    if not fitted:
        return None
    x, y, z = calibration.after.gravity
    forward, left, total = (math.degrees(math.atan2(part, abs(z)))
                            for part in (x, y, math.hypot(x, y)))
    sigma = [math.degrees(fitted[axis].deviation / math.hypot(x, y, z)) for axis in 'xy']
    return (f'{number(total, 1)}°: {number(abs(forward), 1)} ± {number(sigma[0], 1)}° '
            f'{"forward" if forward >= 0 else "backward"} and '
            f'{number(abs(left), 1)} ± {number(sigma[1], 1)}° to the '
            f'{"left" if left >= 0 else "right"}.')


RULES = {
    'Improvement': _gain, 'Worse than before': _worse, 'Contact': _contact,
    'Cross-validation': _trust, 'Uncertain parameters': _uncertain, 'Velocity lag': _lag,
    'Tilt of the base': _tilt, 'Record next': _record_next}

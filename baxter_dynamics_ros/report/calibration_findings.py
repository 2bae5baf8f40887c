"""What a calibration gained, in sentences: did it help, can it be trusted, what to record."""

import numpy as np

from .calibration_terms import parameter_name, PER_JOINT, term_name, value_text
from .findings import Finding, percent, torque
from .page import change, number
from ..calibration.calibrate_robot import sweeps
from ..calibration.calibration_results import Calibration, Selection
from ..model.arrays import Array, Bools
from ..model.joints import JOINTS

_SAME = 0.005  # a residual that differs by a smaller share is the same
_WORSE = 0.02  # a single recording is called worse from this share on
_FEW = 3  # recordings; with fewer, one more tells much
_NAMED = 5  # that are named, before the rest is counted
_LONGEST = 60  # letters of a recording's name within a sentence


def findings(calibration: Calibration) -> list[Finding]:
    """
    Return what was gained, and how far to trust it; as findings.

    Parameters
    ----------
    calibration : Calibration
        What was found.

    Returns
    -------
    list of Finding
        The first says whether it helped.

    """
    found = [_gain(calibration), _left(calibration), _bought(calibration), _harm(calibration),
             _worse(calibration), _contact(calibration), _trust(calibration),
             _uncertain(calibration),
             _record_next(calibration)]
    return [finding for finding in found if finding is not None]


def _gain(calibration: Calibration) -> Finding:
    before, after = calibration.rms_before, calibration.rms_after
    better, worse = after < (1 - _SAME) * before, after > (1 + _SAME) * before
    changes = [f'{joint}\u00a0{change(*pair)}' for joint, *pair in zip(JOINTS, before, after)]
    if better.all():
        text = f'smaller at every joint: {", ".join(changes)}'
    elif better.any():
        text = (f'smaller at {_list(changes, better)}, and no smaller at '
                f'{_list(changes, ~better)}')
    elif worse.any():
        text = f'smaller at no joint: {", ".join(changes)}. Keep the settings that you had'
    else:
        text = 'as it was at every joint: nothing was gained'
    return Finding('Gain', f'On {_those(calibration)} that the fit did not see, the residual is '
                   f'{text}.')


def _left(calibration: Calibration) -> Finding:
    after = calibration.rms_after
    most = int(after.argmax())
    return Finding('What is left', f'{JOINTS[most]} has the largest residual, '
                   f'{torque(after[most])} RMS, which was '
                   f'{torque(calibration.rms_before[most])}. This is the measure for the '
                   "node's residual: what is not well above it is the model's own error, no "
                   'contact and no load.')


def _bought(calibration: Calibration) -> 'Finding | None':
    shares = _shares(calibration.steps)  # (steps, 7)
    names = [term_name(step.term) for step in calibration.steps[1:]]
    mean = shares.mean(1)
    order = [k for k in np.argsort(-mean, kind='stable') if mean[k] > _SAME]
    if not order:
        return None
    text = f'{names[order[0]]}, which takes {percent(mean[order[0]])} off the residual'
    if len(order) > 1:
        text += ', then ' + ', '.join(f'{names[k]} ({percent(mean[k])})' for k in order[1:3])
    text += '; means over the joints.'
    others: dict[int, list[int]] = {}
    for joint in range(len(JOINTS)):
        k = int(shares[:, joint].argmax())
        if k != order[0] and shares[k, joint] > _SAME:
            others.setdefault(k, []).append(joint)
    if others:
        text += ' Single joints gain more by others: ' + '; '.join(
            f'{names[k]} at '
            + ', '.join(f'{JOINTS[i]} ({percent(shares[k, i])})' for i in joints)
            for k, joints in others.items()) + '.'
    nothing = [name for name, step in zip(names, calibration.steps[1:]) if not step.joints]
    if nothing:
        text += f' Kept at no joint: {", ".join(nothing)}.'
    return Finding('What bought most', _sentence([text]))


def _harm(calibration: Calibration) -> 'Finding | None':
    harm = []
    for step, shares in zip(calibration.steps[1:], _shares(calibration.steps)):
        kept = shares[list(step.joints)]
        if step.term in PER_JOINT or step.term == 'spring':
            joints = [JOINTS[i] for i in step.joints if shares[i] < -_SAME]
            if joints:
                harm.append(f'{term_name(step.term)} at {", ".join(joints)}')
        elif len(kept) and kept.mean() < -_SAME:
            harm.append(f'{term_name(step.term)} ({percent(-kept.mean())} more, mean over the '
                        'joints)')
    if not harm:
        return None
    return Finding('Fitted, but no help', 'These make the residual on what was left out greater: '
                   f'{"; ".join(harm)}. The bias is fitted in any case, and what was asked for. '
                   'Ask for less, or record more varied motion.')


def _worse(calibration: Calibration) -> 'Finding | None':
    judged = calibration.judged
    ratio = np.array([one.after / np.maximum(one.before, 1e-9) for one in judged])  # (n, 7)
    worse = ratio > 1 + _WORSE
    if not worse.any():
        return None
    n, joint = np.unravel_index(np.argmax(np.where(worse, ratio, 0.0)), ratio.shape)
    kind = _kind(calibration)
    count = int(worse.any(1).sum())
    what = f'All {count} {kind}s' if count == len(judged) else f'{count} of {len(judged)} {kind}s'
    return Finding('Worse than before', f'{what} {"is" if count == 1 else "are"} predicted worse '
                   f'at some joint ({_list(JOINTS, np.any(worse, axis=0))}), most of all '
                   f'{_shortened(judged[n].name)} at {JOINTS[joint]}: '
                   f'{number(judged[n].before[joint], 2)} before, '
                   f'{torque(judged[n].after[joint])} after.')


def _contact(calibration: Calibration) -> 'Finding | None':
    if not calibration.contacts:
        return None
    joints = sorted({JOINTS.index(contact.joint) for contact in calibration.contacts})
    errors = ', '.join(
        f'{JOINTS[i]} {torque(calibration.rms_after[i])} without it and '
        f'{torque(calibration.rms_with_contact[i])} with it' for i in joints)
    named = '; '.join(map(str, calibration.contacts))
    return Finding('Contact', f'{named}. It is left out of the fit and of the errors on this '
                   f'page: {errors}.')


def _trust(calibration: Calibration) -> Finding:
    n = len(calibration.judged)
    if calibration.by_time:
        return Finding('Judged by time', f'There is one recording. Each of {n} parts of it was '
                       'predicted by a fit to the other parts. Laps repeat: where the motion does '
                       'the same again, the parts have seen each other, and all numbers here look '
                       'better than they would on another motion.')
    return Finding('Judged by recording', f'Each of {n} recordings was predicted, whole, by a fit '
                   f'to the other{"s" if n > 2 else ""}. The numbers hold for a '
                   'next motion that differs from these as these differ from each other.')


def _uncertain(calibration: Calibration) -> 'Finding | None':
    loose = [fitted for fitted in calibration.parameters
             if fitted.term != 'inertial' and fitted.deviation > abs(fitted.value)]
    if not loose:
        return None
    named = [f'{parameter_name(one)} ({value_text(one)})' for one in loose[:_NAMED]]
    more = f', and {len(loose) - _NAMED} more below' if len(loose) > _NAMED else ''
    return Finding('Not told from zero', f'{_sentence(named, ", ")}{more}: the uncertainty is '
                   'larger than the value. Others can take their part, so do not read them as '
                   'properties of the robot.')


def _record_next(calibration: Calibration) -> 'Finding | None':
    wishes = []
    if calibration.by_time:
        wishes.append('a second recording of another motion, so that whole recordings can be left '
                      'out')
    elif len(calibration.judged) < _FEW:
        wishes.append('more recordings of different motions')
    model = calibration.after.effort_model
    lower, upper = model.spring_range
    low, high = np.clip(calibration.s1_range, lower, upper)
    if model.enabled and not sweeps(low, high, model):
        wishes.append(f'a motion that sweeps s1 from {number(lower, 1)} to {number(upper, 1)} '
                      f'rad, for the spring (now {number(low, 2)} to {number(high, 2)})')
    if any(notice.kind in ('unidentifiable', 'still') for notice in calibration.notices):
        wishes.append('a motion in which the joints named in the warnings turn to and fro')
    if not wishes:
        return None
    return Finding('Record next', f'{_sentence(wishes)}. The last command of this page prints an '
                   'exciting motion of one minute.')


def _shares(steps: list[Selection]) -> Array:
    """Return which share of the residual each step took away, (steps, 7), less than 1."""
    rms = np.maximum([step.rms for step in steps], 1e-9)
    return 1.0 - rms[1:] / rms[:-1]


def _those(calibration: Calibration) -> str:
    return 'parts of the recording' if calibration.by_time else 'recordings'


def _kind(calibration: Calibration) -> str:
    return 'part' if calibration.by_time else 'recording'


def _list(texts: list[str] | tuple[str, ...], where: Bools) -> str:
    return ', '.join(texts[i] for i in np.flatnonzero(where))


def _sentence(parts: list[str], between: str = '; ') -> str:
    text = between.join(parts)
    return text[0].upper() + text[1:]


def _shortened(name: str) -> str:
    return name if len(name) <= _LONGEST else name[:_LONGEST - 1] + '…'

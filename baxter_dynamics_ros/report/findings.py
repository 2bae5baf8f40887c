"""What the numbers say, in sentences: how well the model agrees, where it does not, and why."""

from typing import NamedTuple

import numpy as np

from .figures import TERM_NAMES
from .page import number
from ..model.arrays import Array, Bools
from ..model.joints import JOINTS
from ..recordings.evaluation_results import Errors, ErrorStatistics, Statistics

_GOOD = 0.9  # correlation from which on the prediction is said to follow the measurement
_COINCIDE = 1e-9  # [N m]: by more two methods do not differ on the same parameters
_UNIT = '\u00a0N\u00a0m'  # never parted from its number


class Finding(NamedTuple):
    """One thing to know."""

    topic: str
    text: str


def findings(total: Statistics) -> list[Finding]:
    """
    Return what stands out about the model.

    Parameters
    ----------
    total : Total or Evaluation
        Statistics over one or more recordings.

    Returns
    -------
    list of Finding
        The first says how well the model agrees.

    """
    errors = total.methods.get('lagrange_euler')
    if errors is None:
        return [Finding('Agreement', 'There is no valid measured effort, so there is nothing to '
                        'compare with. The figures show what the model predicts.')]
    found = [_agreement(errors), _worst(errors, total.shares), _offset(errors),
             _beyond_the_terms(errors, total.shares), _not_modelled(total.shares)]
    return [finding for finding in found if finding is not None]


def remarks(total: Statistics) -> list[Finding]:
    """Return what stands out about the two methods and about the acceleration; as findings."""
    found = [_two_methods(total.methods), _acceleration(total.estimators)]
    return [finding for finding in found if finding is not None]


def percent(share: float) -> str:
    """Return a share as people say it."""
    return f'{100.0 * share:.0f}\u00a0%' if share >= 0.01 else 'less than 1\u00a0%'


def torque(value: float) -> str:
    """Return a torque with its unit."""
    return number(value, 2) + _UNIT


def _agreement(errors: ErrorStatistics) -> Finding:
    follows = errors.correlation >= _GOOD  # false where NaN
    best, worst = errors.rms.argmin(), errors.rms.argmax()
    text = (f'The error is {torque(errors.rms[best])} RMS at {JOINTS[best]}, the best joint, and '
            f'{torque(errors.rms[worst])} at {JOINTS[worst]}, the worst. Prediction and '
            'measurement correlate by ')
    if follows.all():
        text += f'{_GOOD} and more at every joint.'
    elif follows.any():
        text += (f'{_GOOD} and more at {_joints(follows)}, and by less at '
                 f'{_joints(~follows, errors.correlation)}.')
    else:
        text += f'less than {_GOOD} at every joint: {_joints(~follows, errors.correlation)}.'
    return Finding('Agreement', text)


def _worst(errors: ErrorStatistics, shares: dict[str, Array]) -> Finding:
    worst = errors.rms.argmax()
    term = max(shares, key=lambda name: shares[name][worst])
    greatest = shares[term][worst]
    text = f'{JOINTS[worst]}, with {torque(errors.rms[worst])} RMS'
    if greatest > 0.0:
        text += (f': {percent(errors.rms[worst] / greatest)} of the greatest term there, '
                 f'{TERM_NAMES[term]} ({torque(greatest)})')
    return Finding('Worst joint', f'{text}. A constant offset of '
                   f'{torque(errors.signed_mean[worst])} makes '
                   f'{percent(_constant(errors)[worst])} of its mean square error; the rest '
                   'changes with the motion.')


def _offset(errors: ErrorStatistics) -> 'Finding | None':
    mostly = _constant(errors) > 0.5
    if not mostly.any():
        return None
    return Finding('Offset', 'More than half of the mean square error is a constant offset at '
                   f'{_joints(mostly, errors.signed_mean, _UNIT)}. A bias of the measured effort, '
                   'a load that is not modelled or a tilted base shows like this.')


def _beyond_the_terms(errors: ErrorStatistics, shares: dict[str, Array]) -> 'Finding | None':
    beyond = errors.rms > np.max(list(shares.values()), axis=0)
    if not beyond.any():
        return None
    return Finding('Not in the model', 'The error is greater than every term of the model at '
                   f'{_joints(beyond)}: most of what is measured there comes from elsewhere.')


def _not_modelled(shares: dict[str, Array]) -> 'Finding | None':
    if np.any(shares['friction']) or np.any(shares['other']):
        return None
    return Finding('Friction and bias', 'Both are zero in the parameters used. On a real arm they '
                   'are part of every error until it is calibrated.')


def _two_methods(methods: Errors) -> 'Finding | None':
    if len(methods) < 2:
        return None
    first, second = methods.values()
    apart = np.abs(first.rms - second.rms).max()
    if apart < _COINCIDE:
        return Finding('Two methods', 'Lagrange-Euler and Newton-Euler have the same errors: '
                       f'their RMS differ by less than 10⁻⁹{_UNIT}.')
    return Finding('Two methods', 'The RMS errors of Lagrange-Euler and Newton-Euler differ by up '
                   f'to {apart:.2g}{_UNIT}. On the same parameters they should not.')


def _acceleration(estimators: Errors) -> 'Finding | None':
    if not {'first_difference', 'butterworth_aligned'} <= estimators.keys():
        return None
    first, aligned = (estimators[name].rms for name in ('first_difference', 'butterworth_aligned'))
    most = np.argmax(first - aligned)
    return Finding('Acceleration', "With the paper's first difference in place of the aligned "
                   f'filter, the error at {JOINTS[most]} is {torque(first[most])} RMS instead '
                   f'of {torque(aligned[most])}.')


def _constant(errors: ErrorStatistics) -> Array:
    """Return which part of the mean square error the signed mean makes, (7,), 0 to 1."""
    return errors.signed_mean ** 2 / np.maximum(errors.rms ** 2, 1e-24)


def _joints(where: Bools, values: Array | None = None, unit: str = '') -> str:
    if values is None:
        return ', '.join(JOINTS[i] for i in np.flatnonzero(where))
    return ', '.join(f'{JOINTS[i]} ({number(values[i], 2)}{unit})' for i in np.flatnonzero(where))

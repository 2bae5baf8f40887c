"""Findings of an evaluation: agreement, and the joints where it is missing."""

import numpy as np

from .evaluation_figures import methods_of
from .findings import listed
from .number_text import number, torque
from ..model.arrays import Array
from ..model.joints import JOINTS
from ..recordings.evaluation_results import ErrorStatistics, Statistics

_GOOD = 0.9  # correlation from which the prediction follows the measurement


def _agreement(of: Statistics) -> str:
    errors = of.methods.get('lagrange_euler')
    if errors is None:
        return ('There is no valid measured effort to compare with. The figures show the '
                'prediction.')
    follows = errors.correlation >= _GOOD  # false where NaN
    best, worst = errors.rms.argmin(), errors.rms.argmax()
    text = (f'The RMS error is between {torque(errors.rms[best])} at {JOINTS[best]} and '
            f'{torque(errors.rms[worst])} at {JOINTS[worst]}. ')
    if follows.all():
        return f'{text}Prediction and measurement correlate by {_GOOD} or more at every joint.'
    lower = listed(~follows, _with(errors.correlation))
    above = f'{_GOOD} or more at {listed(follows)}, and lower at' if follows.any() else 'only'
    return f'{text}The correlation of prediction and measurement is {above} {lower}.'


def _offset(of: Statistics) -> 'str | None':
    errors = of.methods.get('lagrange_euler')
    if errors is None or not (mostly := _constant(errors) > 0.5).any():
        return None
    return ('More than half of the mean square error is a constant offset at '
            f'{listed(mostly, _with(errors.signed_mean))}\u00a0N\u00a0m. Possible causes: a bias '
            'of the measured effort, a load that is not modelled, a tilted base.')


def _beyond_the_terms(of: Statistics) -> 'str | None':
    errors = of.methods.get('lagrange_euler')
    if errors is None or not (beyond := errors.rms > np.max([*of.shares.values()], axis=0)).any():
        return None
    return f'The error is larger than every term of the model at {listed(beyond)}.'


def _two_methods(of: Statistics) -> 'str | None':
    if len(methods_of(of)) < 2:
        return None
    first, second = of.methods.values()
    return ('The RMS errors of Lagrange-Euler and Newton-Euler differ by up to '
            f'{np.abs(first.rms - second.rms).max():.2g}\u00a0N\u00a0m. With the same parameters '
            'they should not.')


def _acceleration(of: Statistics) -> 'str | None':
    if not {'first_difference', 'butterworth_aligned'} <= of.estimators.keys():
        return None
    first, aligned = (of.estimators[name].rms
                      for name in ('first_difference', 'butterworth_aligned'))
    most = np.argmax(first - aligned)
    return (f"With the paper's first difference the error at {JOINTS[most]} is "
            f'{torque(first[most])} RMS, with the aligned filter {torque(aligned[most])}.')


RULES = (
    ('Agreement', _agreement), ('Offset', _offset),
    ('Not in the model', _beyond_the_terms), ('Two methods', _two_methods),
    ('Acceleration', _acceleration))


def _constant(errors: ErrorStatistics) -> Array:
    """Return the part (7,) of the mean square error that the signed mean makes, 0 to 1."""
    return errors.signed_mean ** 2 / np.maximum(errors.rms ** 2, 1e-24)


def _with(values: Array) -> list[str]:
    return [f'{joint} ({number(value, 2)})' for joint, value in zip(JOINTS, values)]

"""Findings of an evaluation."""

import numpy as np

from .evaluation_figures import methods_of
from .findings import listed
from .number_text import torque
from ..model.joints import JOINTS
from ..recordings.evaluation_results import BAND, Statistics


def _offset(of: Statistics) -> 'str | None':
    errors = of.methods.get('lagrange_euler')
    if errors is None:
        return None
    mostly = errors.signed_mean ** 2 > 0.5 * errors.rms ** 2
    if of.expected is not None:
        mostly &= np.abs(errors.signed_mean) > BAND * of.expected.deviation
    if not mostly.any():
        return None
    offsets = [f'{joint} ({torque(value)})' for joint, value in zip(JOINTS, errors.signed_mean)]
    return ('More than half of the mean square error is a constant offset at '
            f'{listed(mostly, offsets)}. Possible causes: a bias of the measured effort, a load '
            'that is not modelled, a tilted base.')


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


RULES = (('Offset', _offset), ('Not in the model', _beyond_the_terms),
         ('Two methods', _two_methods), ('Acceleration', _acceleration))

"""Findings of an evaluation."""

import numpy as np

from .findings import listed
from .number_text import torque
from ..model.effort import BAND
from ..model.joints import JOINTS
from ..recordings.evaluation_results import Statistics


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


RULES = (('Offset', _offset), ('Not in the model', _beyond_the_terms))

"""Names and meanings of the terms of a calibration."""

from .number_text import plus_minus
from ..calibration.calibration_results import Calibration
from ..calibration.calibration_results import Fitted
from ..model.joints import JOINTS

MEANINGS = {
    'bias': 'constant offset of the measured effort',
    'spring': 'parallel springs at s1: their shape, or a gain',
    'coulomb': 'friction of constant size, against the motion',
    'viscous': 'friction proportional to velocity',
    'dahl': 'friction with memory: after a reversal it builds up over a small angle',
    'added_inertia': 'apparent inertia in addition to that of the links',
    'tilt': 'the base is not level: direction of gravity',
    'inertial': 'masses, centres of mass and inertias of the links, physically possible',
    'payload': 'mass and centre of mass at the hand',
    'crosstalk': "share of another joint's effort in the measured effort",
    'stiffness': 'cables: effort proportional to the joint angle',
}
_NAMES = {'coulomb': 'Coulomb', 'dahl': 'Dahl', 'inertial': 'links'}

# Terms of one parameter per joint, which is zero without the effect.
PER_JOINT = ('bias', 'coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness')


def term_name(term: str) -> str:
    """Return the readable name of a term."""
    return _NAMES.get(term, term.replace('_', ' '))


def parameter_name(fitted: Fitted) -> str:
    """Return the readable name of a parameter, such as 'Coulomb s1' or 'crosstalk at e1 of e0'."""
    if fitted.term == 'tilt':
        return f'gravity {fitted.component}'
    if fitted.term == 'crosstalk' and fitted.joint is not None:
        return f'crosstalk at {JOINTS[fitted.joint]} {fitted.component}'
    joint = '' if fitted.joint is None or fitted.component else JOINTS[fitted.joint]
    return f'{term_name(fitted.term)} {fitted.component or joint}'


def per_joint(calibration: Calibration, term: str) -> dict[int, Fitted]:
    """Return the fitted parameters of a term by the index of the joint."""
    return {fitted.joint: fitted for fitted in calibration.of_term(term)
            if fitted.joint is not None}


def unit_name(unit: str) -> str:
    """Return a unit as printed; empty if there is none."""
    return '' if unit == '-' else unit.replace('^2', '²')


def value_text(fitted: Fitted) -> str:
    """Return a fitted value with standard deviation and unit."""
    unit = unit_name(fitted.unit)
    return (plus_minus(fitted.value, fitted.deviation)
            + ('\u00a0' + unit.replace(' ', '\u00a0') if unit else ''))

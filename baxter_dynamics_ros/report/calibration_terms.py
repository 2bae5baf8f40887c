"""Names and meanings of the terms of a calibration."""

from .page import plus_minus
from ..calibration.calibration_results import Calibration
from ..calibration.term import Fitted
from ..model.joints import JOINTS

NAMES = {
    'bias': 'bias',
    'spring': 'spring',
    'coulomb': 'Coulomb',
    'viscous': 'viscous',
    'dahl': 'Dahl',
    'added_inertia': 'added inertia',
    'tilt': 'tilt',
    'inertial': 'links',
    'payload': 'payload',
    'stiffness': 'stiffness',
}

MEANINGS = {
    'bias': 'a constant offset of the measured effort',
    'spring': 'the parallel springs at s1: their shape, or a gain on the shape they have',
    'coulomb': 'friction of constant size, against the motion',
    'viscous': 'friction in proportion to the velocity',
    'dahl': 'friction with a memory: after a joint turns round, it builds up over a small angle',
    'added_inertia': "inertia that the effort shows beyond the links', or less of it",
    'tilt': "the base is not level: gravity's direction",
    'inertial': "the links' masses, centres of mass and inertias, as far as bodies can have them",
    'payload': 'what the hand carries: its mass and centre of mass',
    'stiffness': 'cables that a joint bends: effort in proportion to the angle',
}

# One parameter a joint, which is zero where there is nothing of the kind.
PER_JOINT = ('bias', 'coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness')


def term_name(term: str) -> str:
    """Return a term's name as people say it."""
    return NAMES.get(term, term)


def parameter_name(fitted: Fitted) -> str:
    """Return a fitted parameter's name as people say it, such as 'Coulomb s1'."""
    if fitted.term == 'tilt':
        return f'gravity {fitted.component}'
    joint = '' if fitted.joint is None or fitted.component else JOINTS[fitted.joint]
    return f'{term_name(fitted.term)} {fitted.component or joint}'


def per_joint(calibration: Calibration, term: str) -> dict[int, Fitted]:
    """Return index of a joint -> what was fitted to a term of each joint's own."""
    return {fitted.joint: fitted for fitted in calibration.of_term(term)
            if fitted.joint is not None}


def unit_name(unit: str) -> str:
    """Return a unit as it is printed; nothing where there is none."""
    return '' if unit == '-' else unit.replace('^2', '²')


def value_text(fitted: Fitted) -> str:
    """Return what was fitted, with its uncertainty and unit."""
    unit = unit_name(fitted.unit)
    return (plus_minus(fitted.value, fitted.deviation)
            + ('\u00a0' + unit.replace(' ', '\u00a0') if unit else ''))

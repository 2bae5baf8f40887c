"""Tables of a calibration, and the names of its terms and parameters."""

import numpy as np

from .page import change, Column, decimals, number, plus_minus, Table
from ..calibration.calibration_results import Calibration, Fitted
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


def term_name(term: str) -> str:
    """Return the readable name of a term."""
    return _NAMES.get(term, term.replace('_', ' '))


def parameter_name(fitted: Fitted) -> str:
    """Return the readable name of a parameter, such as 'Coulomb s1' or 'crosstalk at e1 of e0'."""
    joint = '' if fitted.joint is None else JOINTS[fitted.joint]
    if fitted.term == 'crosstalk':
        return f'crosstalk at {joint} {fitted.component}'
    name = 'gravity' if fitted.term == 'tilt' else term_name(fitted.term)
    return f'{name} {fitted.component or joint}'


def unit_name(unit: str) -> str:
    """Return a unit as printed; empty if there is none."""
    return '' if unit == '-' else unit.replace('^2', '²')


def value_text(fitted: Fitted) -> str:
    """Return a fitted value with standard deviation and unit."""
    text = f'{plus_minus(fitted.value, fitted.deviation)} {unit_name(fitted.unit)}'
    return text.rstrip().replace(' ', '\u00a0')


def gain_table(calibration: Calibration) -> Table:
    """Return each joint's residual before and after, and its range over the recordings."""
    before, after = calibration.rms_before, calibration.rms_after
    each = np.array([judged.after for judged in calibration.judged])  # (n, 7)
    whole = np.maximum(before, after)
    group = f'after, each {kind(calibration)}'
    return Table(
        'RMS of the residual on left-out data [N m]; bars compare before and after', 'joint',
        JOINTS,
        [Column('before', before, 'together', whole=whole),
         Column('after', after, 'together', whole=whole),
         Column('change', [change(*pair) for pair in zip(before, after)], 'together'),
         Column('best', each.min(0), group), Column('worst', each.max(0), group)])


def steps_table(calibration: Calibration) -> Table:
    """Return each joint's residual as terms were added, where they were kept."""
    first, *steps = calibration.steps
    names = ['before', *(f'+ {term_name(step.term)}' for step in steps), 'after']
    rms = np.array([first.rms, *(
        np.where(np.isin(range(len(JOINTS)), step.joints), step.rms, np.nan) for step in steps),
        calibration.rms_after])
    return Table('RMS of the residual on left-out data [N m] with the terms so far; bars compare '
                 'those of a joint, – where a term was not kept', 'with', names,
                 [Column(joint, column, whole=float(np.fmax.reduce(column)))
                  for joint, column in zip(JOINTS, rms.T)])


def recordings_table(calibration: Calibration) -> Table:
    """Return each recording's residual before, and after a fit to the others."""
    judged = calibration.judged
    time = np.array([*(one.duration for one in judged), calibration.duration])
    before = np.array([*(one.before for one in judged), calibration.rms_before])  # (n + 1, 7)
    after = np.array([*(one.after for one in judged), calibration.rms_after])
    columns = [Column('time [s]', time, digits=0)]
    for joint, *pair in zip(JOINTS, before.T, after.T):
        columns += [Column(label, values, joint, whole=np.max(pair))
                    for label, values in zip(('before', 'after'), pair)]
    return Table(f'RMS of the residual [N m] on each {kind(calibration)}, fitted to the others; '
                 'bars compare those of a joint', kind(calibration),
                 [*(one.name for one in judged), 'together'], columns, foot=True)


def deviation_table(calibration: Calibration) -> 'Table | None':
    """Return the expected deviation of the residual; None if it is not known."""
    model = calibration.after.model.effort_model
    if not np.any(model.deviation):
        return None
    return Table('Standard deviation of the residual to expect with these parameters', 'joint',
                 JOINTS, [Column('at rest [N m]', model.deviation),
                          Column('per velocity [N m s/rad]', model.deviation_velocity),
                          Column('per acceleration [N m s²/rad]', model.deviation_acceleration)])


def parameters_table(fitted: list[Fitted]) -> Table:
    """Return parameters before and after, with standard deviation and unit."""
    texts = zip(('before', 'after', '±', 'change / ±', 'unit'), zip(*map(_texts, fitted)))
    return Table('Fitted parameters; ± is one standard deviation', 'parameter',
                 [parameter_name(one) for one in fitted],
                 [Column(label, column) for label, column in texts])


def links_table(fitted: list[Fitted]) -> Table:
    """Return the links' masses and moments of mass."""
    quantities = {one.component: f'{one.component} [{unit_name(one.unit)}]' for one in fitted}
    columns = [Column(label, [_texts(one)[k] for one in fitted if one.component == component],
                      heading) for component, heading in quantities.items()
               for k, label in enumerate(('before', 'after', '±'))]
    links = dict.fromkeys(str(one.joint + 1) for one in fitted if one.joint is not None)
    return Table("Masses of the links, and mass times centre of mass along the link's axes",
                 'link', list(links), columns)


def _texts(fitted: Fitted) -> tuple[str, ...]:
    """Return before, after, standard deviation, change in standard deviations, and unit."""
    sigma = fitted.deviation
    digits = decimals(sigma)
    moved = (fitted.value - fitted.before) / sigma if sigma > 0.0 else np.nan
    return (*(number(value, digits) for value in (fitted.before, fitted.value, sigma)),
            number(moved, 1), unit_name(fitted.unit))


def kind(calibration: Calibration) -> str:
    """Return what the fit left out in turn."""
    return 'part' if calibration.by_time else 'recording'

"""Tables of a calibration."""

import math

import numpy as np

from .number_text import change, decimals, number
from .table import Column, Table
from .term_names import parameter_name, term_name, unit_name
from ..calibration.calibration_results import Calibration
from ..calibration.calibration_results import Fitted
from ..model.joints import JOINTS


def gain_table(calibration: Calibration) -> Table:
    """Return each joint's residual before and after, and its range over the recordings."""
    before, after = calibration.rms_before, calibration.rms_after
    each = np.array([judged.after for judged in calibration.judged])  # (n, 7)
    whole = np.maximum(before, after)
    group = 'after, each ' + ('part' if calibration.by_time else 'recording')
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
    before, after = np.array([(one.before, one.after) for one in judged]).swapaxes(0, 1)
    columns = [Column('time [s]', np.array([one.duration for one in judged]), digits=0,
                      foot=calibration.duration)]
    for i, joint in enumerate(JOINTS):
        whole = float(max(before[:, i].max(), after[:, i].max()))
        columns += [Column('before', before[:, i], joint, 3, whole, calibration.rms_before[i]),
                    Column('after', after[:, i], joint, 3, whole, calibration.rms_after[i])]
    kind = 'part' if calibration.by_time else 'recording'
    return Table(f'RMS of the residual [N m] on each {kind}, fitted to the others; bars compare '
                 'those of a joint', kind, [one.name for one in judged], columns, 'together')


def deviation_table(calibration: Calibration) -> 'Table | None':
    """Return the expected deviation of the residual; None if it is not known."""
    model = calibration.after.model.effort_model
    parts = {'at rest [N m]': model.deviation,
             'per velocity [N m s/rad]': model.deviation_velocity,
             'per acceleration [N m s²/rad]': model.deviation_acceleration}
    if not np.any(model.deviation):
        return None
    return Table('Standard deviation of the residual to expect with these parameters', 'joint',
                 JOINTS, [Column(label, values) for label, values in parts.items()])


def parameters_table(fitted: list[Fitted]) -> Table:
    """Return parameters before and after, with standard deviation and unit."""
    texts = zip(('before', 'after', '±', 'change / ±', 'unit'), zip(*map(_texts, fitted)))
    return Table('Fitted parameters; ± is one standard deviation', 'parameter',
                 [parameter_name(one) for one in fitted],
                 [Column(label, column) for label, column in texts])


def links_table(fitted: list[Fitted]) -> Table:
    """Return the links' masses and moments of mass."""
    rows: dict[str, dict[int, tuple[str, ...]]] = {}
    for one in fitted:
        assert one.joint is not None  # link i is moved by joint i
        rows.setdefault(f'{one.component} [{unit_name(one.unit)}]', {})[one.joint] = _texts(one)
    return Table("Masses of the links, and mass times centre of mass along the link's axes",
                 'link', [str(link + 1) for link in next(iter(rows.values()))],
                 [Column(label, [texts[k] for texts in of.values()], quantity)
                  for quantity, of in rows.items()
                  for k, label in enumerate(('before', 'after', '±'))])


def _texts(fitted: Fitted) -> tuple[str, ...]:
    """Return before, after, standard deviation, change in standard deviations, and unit."""
    sigma = fitted.deviation
    digits = decimals(sigma)
    moved = (fitted.value - fitted.before) / sigma if sigma > 0.0 else math.nan
    return (*(number(value, digits) for value in (fitted.before, fitted.value, sigma)),
            number(moved, 1), unit_name(fitted.unit))

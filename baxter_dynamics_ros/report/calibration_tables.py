"""The calibration report's tables, as data."""

import math

import numpy as np

from .calibration_terms import parameter_name, term_name, unit_name
from .model_figures import spring_effort
from .page import change, decimals, NO_VALUE, number
from .tables import Column, Table
from ..calibration.calibration_results import Calibration, Selection
from ..calibration.term import Fitted
from ..model.arrays import Array
from ..model.joints import JOINTS, N_JOINTS

_ANGLES = 9  # at which the spring is listed


def gain_table(calibration: Calibration) -> Table:
    """Return each joint's residual before and after, and how far the recordings differ."""
    before, after = calibration.rms_before, calibration.rms_after
    each = np.array([judged.after for judged in calibration.judged])  # (n, 7)
    whole = np.maximum(before, after)
    group = 'after, each ' + ('part' if calibration.by_time else 'recording')
    return Table(
        'RMS of the residual on what was left out [N m]; the bars compare before and after',
        'joint', JOINTS,
        (Column('before', before, 'together', whole=whole),
         Column('after', after, 'together', whole=whole),
         Column('change', [change(*pair) for pair in zip(before, after)], 'together'),
         Column('best', each.min(0), group), Column('worst', each.max(0), group)))


def steps_table(calibration: Calibration) -> Table:
    """Return what was left of each joint's residual as terms were added."""
    first, *steps = calibration.steps
    rows = ['before', *(f'+ {term_name(step.term)}' for step in steps), 'after']
    rms = np.array([first.rms, *(_where_kept(step) for step in steps), calibration.rms_after])
    return Table(
        'RMS of the residual on what was left out [N m], with all terms so far; '
        '– where a term was not kept', 'with', tuple(rows),
        tuple(Column(joint, column) for joint, column in zip(JOINTS, rms.T)))


def recordings_table(calibration: Calibration) -> Table:
    """Return each recording's residual, before and after, predicted by a fit to the others."""
    judged = calibration.judged
    before, after = (np.array([getattr(one, when) for one in judged])
                     for when in ('before', 'after'))  # (n, 7)
    columns = [Column('time [s]', np.array([one.duration for one in judged]), digits=0,
                      foot=calibration.duration)]
    for i, joint in enumerate(JOINTS):
        whole = np.full(len(judged), max(before[:, i].max(), after[:, i].max()))
        columns += [
            Column('before', before[:, i], joint, whole=whole,
                   foot=calibration.rms_before[i]),
            Column('after', after[:, i], joint, whole=whole,
                   foot=calibration.rms_after[i])]
    kind = 'part' if calibration.by_time else 'recording'
    return Table(f'RMS of the residual [N m] on each {kind}, by a fit to the others; the bars '
                 'compare those of a joint', kind, tuple(one.name for one in judged),
                 tuple(columns), 'together')


def parameters_table(fitted: list[Fitted]) -> Table:
    """Return parameters with value before and after, uncertainty and unit."""
    texts = np.array([_texts(one) for one in fitted]).T  # (4, n)
    labels = ('before', 'after', '±', 'change / ±')
    return Table('Parameters that were fitted; ± is one standard deviation', 'parameter',
                 tuple(map(parameter_name, fitted)),
                 (*(Column(label, tuple(map(str, column)))
                    for label, column in zip(labels, texts)),
                  Column('unit', tuple(unit_name(one.unit) for one in fitted))))


def links_table(fitted: list[Fitted]) -> Table:
    """Return the links' masses and moments of mass, which have four parameters each."""
    rows: dict[str, dict[str, tuple[str, ...]]] = {}
    columns: list[Column] = []
    for one in fitted:
        assert one.joint is not None  # link i is moved by joint i
        rows.setdefault(f'{one.component} [{unit_name(one.unit)}]', {})[
            str(one.joint + 1)] = _texts(one)
    links = list(next(iter(rows.values())))
    for quantity, of in rows.items():
        columns += [Column(label, tuple(of[link][k] for link in links), quantity)
                    for k, label in enumerate(('before', 'after', '±'))]
    return Table("The links' masses, and mass times centre of mass along the link's axes", 'link',
                 tuple(links), tuple(columns))


def spring_table(calibration: Calibration) -> Table:
    """Return spring and bias at s1 before and after, at some angles, and where s1 was."""
    after = calibration.after.model.effort_model
    lower, upper = after.spring_range
    angle = np.linspace(lower, upper, _ANGLES)
    old, new = (spring_effort(model, angle)
                for model in (calibration.before.model.effort_model, after))
    low, high = calibration.s1_range
    return Table(
        'Spring and bias at s1 [N m]', 's1 [rad]', tuple(number(x, 2) for x in angle),
        (Column('before', old, digits=2), Column('after', new, digits=2),
         Column('change', new - old, digits=2),
         Column('s1 was there', tuple('yes' if low <= x <= high else NO_VALUE for x in angle))))


def _texts(fitted: Fitted) -> tuple[str, str, str, str]:
    """Return value before, after, uncertainty, and the change in units of that."""
    sigma = fitted.deviation
    digits = decimals(sigma)
    moved = (fitted.value - fitted.before) / sigma if sigma > 0.0 else math.nan
    return (number(fitted.before, digits), number(fitted.value, digits), number(sigma, digits),
            number(moved, 1))


def _where_kept(step: Selection) -> Array:
    rms = np.full(N_JOINTS, np.nan)
    kept = list(step.joints)
    rms[kept] = step.rms[kept]
    return rms

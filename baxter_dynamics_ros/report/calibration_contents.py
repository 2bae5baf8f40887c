"""Figures and tables of a calibration, and the names of its terms and parameters."""

from typing import Any

from matplotlib.ticker import LogLocator, NullLocator
import numpy as np

from .drawing import (FAINT, frame, legend, MEASURED as BEFORE, MODEL as AFTER, panels, Picture,
                      SHADE, svg, zero_line)
from .page import change, Column, decimals, joint_columns, number, Table
from ..calibration.calibration_results import Calibration, Fitted
from ..model import Array, EffortModel, JOINTS, N_JOINTS, S1

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

_RING: dict[str, Any] = {'marker': 'o', 'linestyle': '', 'color': 'white',
                         'markeredgecolor': BEFORE, 'markeredgewidth': 1.7, 'markersize': 7.0}
_EACH = '#6f9bc4'  # single recordings
_SMALLER, _LARGER = '#bcd9ee', '#f0b79b'
_SMALLEST = 1e-3  # lower end of the logarithmic scale [N m]


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


def gain_picture(calibration: Calibration) -> Picture:
    """Draw each joint's residual on left-out data, before and after."""
    before, after = np.maximum([calibration.total.before, calibration.total.after], _SMALLEST)
    each = np.maximum([judged.after for judged in calibration.judged], _SMALLEST)  # (n, 7)
    rows = np.arange(N_JOINTS)
    figure, (axis,) = panels((2.2,), left=0.34)
    axis.set_xscale('log')
    axis.barh(rows, after - before, left=before, height=0.12,
              color=np.where(after <= before, _SMALLER, _LARGER))
    axis.plot(before, rows, label='before', **_RING)
    axis.plot(after, rows, 'o', color=AFTER, markersize=7, label='after')
    axis.plot(each.ravel(), np.tile(rows, len(each)), '|', color=_EACH, markersize=8,
              label=f'after, each {calibration.fold}', zorder=1.9)
    low, high = min(before.min(), each.min()), max(before.max(), each.max())
    middle = np.sqrt(low * high)
    axis.set_xlim(min(0.8 * low, middle / 3), max(1.25 * high, 3 * middle))
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 200 * low else (1.0,)))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_formatter('{x:g}')
    axis.set_yticks(rows, JOINTS)
    axis.set_ylim(N_JOINTS - 0.5, -0.5)
    axis.grid(axis='y', visible=False)
    axis.tick_params(axis='y', length=0)
    axis.set_xlabel('RMS of the residual on left-out data [N m]', labelpad=2)
    legend(figure)
    return Picture('gain', "RMS of each joint's residual on left-out data, before and after",
                   svg(figure))


def parameters_picture(calibration: Calibration) -> 'Picture | None':
    """Draw the parameters fitted to joints, one panel per term; None if there are none."""
    terms = dict.fromkeys(one.term for one in calibration.parameters if not one.component)
    if not terms:
        return None
    figure, axes = panels((0.92,) * len(terms), gap=0.46, top=0.52, sharex=False)
    for axis, term in zip(axes, terms):
        fitted = calibration.of_term(term)
        joints = [one.joint for one in fitted if one.joint is not None]
        axis.plot(joints, [one.before for one in fitted], label='before', **_RING)
        axis.errorbar(joints, [one.value for one in fitted],
                      yerr=[one.deviation for one in fitted], fmt='o', color=AFTER,
                      markersize=5.0, elinewidth=1.4, capsize=3.5, label='after, ± deviation')
        if kept := sorted({*range(N_JOINTS)} - {*joints}):
            values = getattr(calibration.after.model.effort_model, term)
            axis.plot(kept, [values[i] for i in kept], 'x', color=FAINT, markersize=5.0,
                      label='not fitted')
        zero_line(axis)
        axis.grid(axis='x', visible=False)
        axis.margins(y=0.12)
        axis.set_title(f'{term_name(term)} [{unit_name(fitted[0].unit)}]', loc='left', pad=4)
        axis.set_xticks(range(N_JOINTS), JOINTS)
        axis.set_xlim(-0.5, N_JOINTS - 0.5)
    legend(figure)
    return Picture('parameters', 'Parameters of each joint with standard deviations', svg(figure))


def spring_picture(calibration: Calibration) -> 'Picture | None':
    """Draw the spring at s1 with the bias there, before and after; None if there is no spring."""
    before, after = (settings.model.effort_model
                     for settings in (calibration.before, calibration.after))
    if not (before.has_spring or after.has_spring):
        return None
    lower, upper = after.spring_range.tolist()
    low, high = np.clip(calibration.s1_range, lower, upper)
    angle = np.linspace(lower, upper, 241)
    old, new = _spring_effort(before, angle), _spring_effort(after, angle)
    seen = (angle >= low) & (angle <= high)
    figure, axes = panels((1.56, 0.8))
    axes[0].plot(angle, old, color=BEFORE, linewidth=2.6, label='before')
    zero_line(axes[1])
    for axis, values, label in zip(axes, (new, new - old), ('effort [N m]', 'change [N m]')):
        axis.plot(angle, values, color=AFTER, alpha=0.35, linewidth=1.2)
        axis.plot(angle[seen], values[seen], color=AFTER, linewidth=1.8, label='after')
        axis.axvspan(low, high, color=SHADE, linewidth=0.0, zorder=0, label='range of s1')
        frame(axis, label)
    axes[1].set_xlim(lower, upper)
    axes[1].set_xlabel('angle of s1 [rad]', labelpad=2)
    legend(figure)
    return Picture('spring', 'Spring and bias at s1 over its angle, before and after; s1 was '
                   f'between {low:.2f} and {high:.2f} rad', svg(figure))


def _spring_effort(model: EffortModel, angle: Array) -> Array:
    """Return spring and bias at s1 (n,) [N m] over its angle (n,) [rad]."""
    q = np.zeros((len(angle), N_JOINTS))
    q[:, S1] = angle
    return model.spring(q)[:, S1] + model.bias[S1]


def gain_table(calibration: Calibration) -> Table:
    """Return each joint's residual before and after, and its range over the recordings."""
    before, after = calibration.total.before, calibration.total.after
    each = np.array([judged.after for judged in calibration.judged])  # (n, 7)
    whole = np.maximum(before, after)
    group = f'after, each {calibration.fold}'
    return Table('RMS of the residual on left-out data [N m]; bars compare before and after', [
        Column('before', before, 'together', whole=whole),
        Column('after', after, 'together', whole=whole),
        Column('change', [change(*pair) for pair in zip(before, after)], 'together'),
        Column('best', each.min(0), group), Column('worst', each.max(0), group)])


def steps_table(calibration: Calibration) -> Table:
    """Return each joint's residual as terms were added, where they were kept."""
    steps, total = calibration.steps[1:], calibration.total
    rms = [np.where(np.isin(range(N_JOINTS), step.joints), step.rms, np.nan) for step in steps]
    return Table('RMS of the residual on left-out data [N m] with the terms so far; bars compare '
                 'the values of a joint; – where a term was not kept; outliers count less in the '
                 'rows of terms', joint_columns([total.before, *rms, total.after]), 'with',
                 ['before', *(f'+ {term_name(step.term)}' for step in steps), 'after'])


def recordings_table(calibration: Calibration) -> Table:
    """Return each recording's residual before, and after a fit to the others."""
    names, time, before, after, _ = zip(*calibration.judged, calibration.total)
    columns = [Column('time [s]', np.array(time), digits=0)]
    for joint, *pair in zip(JOINTS, np.transpose(before), np.transpose(after)):
        columns += [Column(label, values, joint, whole=np.max(pair))
                    for label, values in zip(('before', 'after'), pair)]
    return Table(f'RMS of the residual [N m] on each {calibration.fold} with a fit to the others; '
                 'bars compare the values of a joint', columns, calibration.fold, names, foot=True)


def deviation_table(calibration: Calibration) -> 'Table | None':
    """Return the expected deviation of the residual; None if it is not known."""
    model = calibration.after.model.effort_model
    return Table('Standard deviation of the residual to expect with these parameters', [
        Column('at rest [N m]', model.deviation),
        Column('per velocity [N m s/rad]', model.deviation_velocity),
        Column('per acceleration [N m s²/rad]', model.deviation_acceleration)
    ]) if model.deviation.any() else None


def parameters_table(fitted: list[Fitted]) -> Table:
    """Return parameters before and after, with standard deviation and unit."""
    texts = zip(('before', 'after', '±', 'change / ±', 'unit'), zip(*map(_texts, fitted)))
    return Table('Fitted parameters; ± is one standard deviation',
                 [Column(label, column) for label, column in texts], 'parameter',
                 [parameter_name(one) for one in fitted])


def links_table(fitted: list[Fitted]) -> Table:
    """Return the links' masses and moments of mass, four quantities of each link in turn."""
    columns = [Column(label, [_texts(one)[k] for one in fitted[i::4]],
                      f'{fitted[i].component} [{unit_name(fitted[i].unit)}]')
               for i in range(4) for k, label in enumerate(('before', 'after', '±'))]
    return Table("Masses of the links, and mass times centre of mass along the link's axes",
                 columns, 'link', [str(i + 1) for i in range(N_JOINTS)])


def _texts(fitted: Fitted) -> tuple[str, ...]:
    """Return before, after, standard deviation, change in standard deviations, and unit."""
    sigma = fitted.deviation
    digits = decimals(sigma)
    moved = (fitted.value - fitted.before) / sigma if sigma > 0.0 else np.nan
    return (*(number(value, digits) for value in (fitted.before, fitted.value, sigma)),
            number(moved, 1), unit_name(fitted.unit))

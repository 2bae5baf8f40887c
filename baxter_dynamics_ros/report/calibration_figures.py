"""Figures of a calibration: residuals, fitted parameters, and the spring."""

from typing import Any

from matplotlib.ticker import LogLocator, NullLocator
import numpy as np

from .calibration_tables import kind, term_name, unit_name
from .drawing import (FAINT, frame, legend, MEASURED as BEFORE, MODEL as AFTER, panels, Picture,
                      SHADE, svg, zero_line)
from ..calibration.calibration_results import Calibration
from ..model.arrays import Array
from ..model.effort import EffortModel
from ..model.joints import JOINTS, N_JOINTS, S1

_RING: dict[str, Any] = {'marker': 'o', 'linestyle': '', 'color': 'white',
                         'markeredgecolor': BEFORE, 'markeredgewidth': 1.7, 'markersize': 7.0}
_EACH = '#6f9bc4'  # single recordings
_SMALLER, _LARGER = '#bcd9ee', '#f0b79b'
_SMALLEST = 1e-3  # lower end of the logarithmic scale [N m]
# Terms of one parameter per joint, which is zero without the effect.
_PER_JOINT = ('bias', 'coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness')


def gain_picture(calibration: Calibration) -> Picture:
    """Draw each joint's residual on left-out data, before and after."""
    before, after = (np.maximum(rms, _SMALLEST)
                     for rms in (calibration.rms_before, calibration.rms_after))
    each = np.maximum([judged.after for judged in calibration.judged], _SMALLEST)  # (n, 7)
    rows = np.arange(N_JOINTS)
    figure, (axis,) = panels((2.2,), left=0.34)
    axis.set_xscale('log')
    axis.barh(rows, after - before, left=before, height=0.12,
              color=np.where(after <= before, _SMALLER, _LARGER))
    axis.plot(before, rows, label='before', **_RING)
    axis.plot(after, rows, 'o', color=AFTER, markersize=7, label='after')
    axis.plot(each.ravel(), np.tile(rows, len(each)), '|', color=_EACH, markersize=8,
              label=f'after, each {kind(calibration)}', zorder=1.9)
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
    fits = {term: fits for term in _PER_JOINT if (fits := calibration.of_term(term))}
    if not fits:
        return None
    figure, axes = panels((0.92,) * len(fits), gap=0.46, sharex=False)
    for axis, (term, fitted) in zip(axes, fits.items()):
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
    return Picture('parameters', 'Parameters of each joint with standard deviations',
                   svg(figure))


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

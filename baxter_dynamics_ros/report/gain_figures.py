"""What a calibration gained, drawn: before and after, and what each term took away."""

from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator, StrMethodFormatter
import numpy as np

from .calibration_terms import term_name
from .drawing import ALERT, FAINT, INK, Picture, place, sheet, styled, svg
from .page import change, number
from ..calibration.calibration_results import Calibration
from ..model.arrays import Array
from ..model.joints import JOINTS

BEFORE, AFTER = '#e07b1a', '#0b3c68'
_EACH = '#6f9bc4'  # of single recordings
_TAKEN, _ADDED, _NOT_KEPT = '#bcd9ee', '#f0b79b', '#d5dae0'
_WORSE = 1.005  # times the residual before, from which a number shows alarm
_SMALLEST = 1e-3  # [N m]: a logarithmic scale needs an end


def gain_picture(name: str, calibration: Calibration) -> Picture:
    """
    Draw each joint's residual on what was left out, before and after.

    Parameters
    ----------
    name : str
        Of the figure, within the page.
    calibration : Calibration
        What to draw.

    """
    before, after = (np.maximum(rms, _SMALLEST)
                     for rms in (calibration.rms_before, calibration.rms_after))
    each = np.maximum([judged.after for judged in calibration.judged], _SMALLEST)  # (n, 7)
    with styled():
        figure = sheet('', 3.0)
        axis = figure.add_axes(place(figure, 0.34, 0.46, 2.2, right=0.62))
        axis.set_xscale('log')
        for i in range(len(JOINTS)):
            axis.plot([before[i], after[i]], [i, i], linewidth=2.5, solid_capstyle='butt',
                      color=_TAKEN if after[i] <= before[i] else _ADDED, zorder=2)
            axis.text(1.02, i, change(before[i], after[i]), va='center',
                      transform=axis.get_yaxis_transform(),
                      color=INK if after[i] <= _WORSE * before[i] else ALERT)
        rows = np.arange(len(JOINTS))
        part = 'part' if calibration.by_time else 'recording'
        axis.plot(each.ravel(), np.tile(rows, len(each)), '|', color=_EACH, markersize=8,
                  label=f'after, each {part}', zorder=2.5)
        axis.plot(before, rows, 'o', color='white', markeredgecolor=BEFORE, markeredgewidth=1.8,
                  markersize=6.5, label='before', zorder=3)
        axis.plot(after, rows, 'o', color=AFTER, markersize=7, label='after', zorder=4)
        axis.set_yticks(rows, JOINTS)
        axis.set_ylim(len(JOINTS) - 0.5, -0.5)
        _log_ticks(axis, np.concatenate([before, after, each.ravel()]))
        axis.grid(axis='y', visible=False)
        axis.tick_params(axis='y', length=0)
        axis.set_xlabel('RMS of the residual on what was left out [N m]', labelpad=2)
        handles, labels = axis.get_legend_handles_labels()
        figure.legend([handles[i] for i in (1, 2, 0)], [labels[i] for i in (1, 2, 0)],
                      loc='upper center', ncols=3, frameon=False, handlelength=1.0,
                      columnspacing=1.6, borderaxespad=0.2)
        return Picture(name, "RMS of each joint's residual on what was left out, before and after",
                       svg(figure))


def steps_picture(name: str, calibration: Calibration, joint: int) -> Picture:
    """
    Draw what is left of one joint's residual as terms are added.

    Parameters as for :func:`gain_picture`; joint is its index.
    """
    steps = calibration.steps
    rms = [float(step.rms[joint]) for step in steps]
    reach = max(*rms, _SMALLEST)
    with styled():
        figure = sheet(JOINTS[joint], 0.34 + 0.205 * len(steps) + 0.46)
        axis = figure.add_axes(place(figure, 1.16, 0.46, 0.205 * len(steps)))
        for row, step in enumerate(steps):
            _draw_step(axis, row, rms[max(row - 1, 0)], rms[row],
                       row == 0 or joint in step.joints, reach)
        axis.set_yticks(range(len(steps)),
                        ['before', *(f'+ {term_name(step.term)}' for step in steps[1:])])
        for label, step in zip(axis.get_yticklabels()[1:], steps[1:]):
            label.set_color(INK if joint in step.joints else FAINT)
        axis.set_ylim(len(steps) - 0.45, -0.55)
        axis.set_xlim(0.0, 1.22 * reach)
        axis.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        axis.grid(axis='y', visible=False)
        axis.tick_params(axis='y', length=0)
        axis.set_xlabel('RMS on what was left out [N m]', labelpad=2)
        kept = ', '.join(term_name(step.term) for step in steps if joint in step.joints) or 'none'
        return Picture(name, f"What each term took away from {JOINTS[joint]}'s residual: from "
                       f'{rms[0]:.3f} to {rms[-1]:.3f} N m RMS; kept: {kept}', svg(figure))


def _draw_step(axis: Axes, row: int, last: float, now: float, kept: bool, reach: float) -> None:
    """Draw the bar of one step: what is left, and what this term took away or added."""
    axis.barh(row, min(last, now), height=0.66, color=AFTER if kept else _NOT_KEPT)
    axis.barh(row, abs(last - now), left=min(last, now), height=0.66,
              color=_TAKEN if now <= last else _ADDED)
    if kept:
        axis.text(max(last, now) + 0.02 * reach, row, number(now), va='center',
                  color=INK if now <= _WORSE * last else ALERT)


def _log_ticks(axis: Axes, values: Array) -> None:
    """Set the limits, and ticks at 1, 2 and 5 as far as there is room."""
    middle = np.sqrt(values.min() * values.max())
    low, high = min(0.8 * values.min(), middle / 3), max(1.25 * values.max(), middle * 3)
    axis.set_xlim(low, high)
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 300 * low else (1.0,)))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.xaxis.set_major_formatter(StrMethodFormatter('{x:g}'))

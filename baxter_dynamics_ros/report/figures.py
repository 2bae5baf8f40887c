"""The evaluation's figures: effort and its error, acceleration estimators, the effort's terms."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

from .drawing import (ALERT, draw_band, frame, panels, Picture, place, span, Stroke, styled, svg,
                      WIDTH, zero_line)
from ..model.arrays import Array
from ..model.joints import JOINTS, N_JOINTS
from ..recordings.evaluation_results import Evaluation, TERMS

# Bands are drawn with at most so many intervals: a page with many recordings grows with each.
FINE, COARSE = 500, 200

# Told apart by lightness, too: for eyes that see fewer colours, and for paper. Newton-Euler lies
# under Lagrange-Euler, and as the two coincide, it must be the wider to be seen.
STROKES = {
    'newton_euler': Stroke('Newton-Euler', '#a5cdea', 4.0),
    'measured': Stroke('measured', '#e07b1a', 1.8),
    'lagrange_euler': Stroke('Lagrange-Euler', '#0b3c68'),
    'first_difference': Stroke('first difference', '#eec08d'),
    'butterworth_live': Stroke('live', '#2f9880'),
    'butterworth_aligned': Stroke('aligned', '#0b3c68'),
}
TERM_NAMES = {term: term for term in TERMS} | {'coriolis': 'Coriolis'}
TERM_COLORS = dict(zip(TERMS, ('#0072b2', '#56b4e9', '#009e73', '#e69f00', '#cc79a7', '#8a94a0')))


def effort_picture(name: str, evaluation: Evaluation, joint: int, intervals: int) -> Picture:
    """
    Draw one joint of the paper's figures 5 to 7: measured and predicted effort, and the errors.

    Parameters
    ----------
    name : str
        Of the file, without folder and ending.
    evaluation : Evaluation
        What to draw; without methods the predicted effort alone.
    joint : int
        Index of the joint.
    intervals : int
        FINE or COARSE.

    """
    errors = [method for method in STROKES if method in evaluation.methods]
    signals = [signal for signal in ('newton_euler', 'measured', 'lagrange_euler')
               if signal in evaluation.bands and (errors or signal != 'measured')]
    with styled():
        figure, axes = panels(JOINTS[joint], evaluation.time, (1.75, 1.05)[:1 + bool(errors)])
        for signal in signals:
            draw_band(axes[0], evaluation.time, evaluation.bands[signal], joint, STROKES[signal],
                      intervals)
        _legend(figure, axes[0])
        frame(axes[0], 'effort [N m]')
        what = 'predicted'
        if errors:
            rms = evaluation.methods['lagrange_euler'].rms[joint]
            what = f'measured and predicted, and their difference, RMS {rms:.3f} N m'
            for method in errors:
                draw_band(axes[1], evaluation.time, evaluation.bands['error_' + method], joint,
                          STROKES[method], intervals)
            zero_line(axes[1])
            axes[1].set_title(f'measured − predicted, RMS {rms:.3f} N m', loc='left', pad=4)
            frame(axes[1], 'error [N m]')
        return Picture(name, f'Effort at {JOINTS[joint]} over time: {what}', svg(figure))


def estimator_picture(name: str, evaluation: Evaluation, joint: int, intervals: int) -> Picture:
    """
    Draw one joint's error with each way of finding the acceleration.

    The scale is that of the last, the aligned one where there is one; what goes beyond is cut
    off, and the picture says so.
    Parameters as for :func:`effort_picture`.
    """
    bands = {estimator: evaluation.bands['error_' + estimator] for estimator in STROKES
             if estimator in evaluation.estimators}
    spans = {estimator: span(band, joint) for estimator, band in bands.items()}
    lower, upper = list(spans.values())[-1]
    margin = 0.35 * (upper - lower)
    limits = min(lower, 0.0) - margin, max(upper, 0.0) + margin
    beyond = [f'{STROKES[estimator].label} {max(-low, high):.3g}'
              for estimator, (low, high) in spans.items() if low < limits[0] or high > limits[1]]
    with styled():
        figure, (axis,) = panels(JOINTS[joint], evaluation.time, (1.75,), note=True)
        for estimator, band in bands.items():
            draw_band(axis, evaluation.time, band, joint, STROKES[estimator], intervals)
        _legend(figure, axis)
        zero_line(axis)
        if beyond:
            axis.set_title(f'cut off; reaches: {", ".join(beyond)} N m', loc='left', pad=4,
                           color=ALERT)
        frame(axis, 'error [N m]', limits)
        what = ', '.join(STROKES[estimator].label for estimator in bands)
        return Picture(name, f'Error of the effort at {JOINTS[joint]} over time, with the '
                       f'acceleration by {what}', svg(figure))


def terms_picture(name: str, shares: dict[str, Array]) -> Picture:
    """Draw what the predicted effort is made of: the RMS of each term, put end to end."""
    rms = np.array([shares[term] for term in TERMS])  # (6, 7) [N m]
    part = 100.0 * rms / np.maximum(rms.sum(axis=0), 1e-12)  # [%]
    with styled():
        figure = Figure(figsize=(WIDTH, 3.1))
        axis = figure.add_axes(place(figure, 0.34, 0.46, 2.1))
        start = np.zeros(N_JOINTS)
        for term, width in zip(TERMS, part):
            axis.barh(JOINTS, width, left=start, height=0.72, color=TERM_COLORS[term],
                      label=TERM_NAMES[term], edgecolor='white', linewidth=0.6)
            start += width
        axis.invert_yaxis()
        axis.set_xlim(0.0, 100.0)
        axis.set_xlabel('share in the sum of the RMS values [%]', labelpad=2)
        axis.grid(axis='y', visible=False)
        axis.tick_params(axis='y', length=0)
        figure.legend(loc='upper center', ncols=3, frameon=False, handlelength=1.0,
                      columnspacing=1.6, borderaxespad=0.2)
        return Picture(name, 'RMS of each term of the predicted effort, as a share, per joint',
                       svg(figure))


def _legend(figure: Figure, axis: Axes) -> None:
    handles = {line.get_label(): line for line in axis.lines}
    labels = [stroke.label for stroke in STROKES.values() if stroke.label in handles]
    legend = figure.legend(
        [handles[label] for label in labels], labels, loc='upper right', ncols=len(labels) or 1,
        frameon=False, handlelength=1.3, handletextpad=0.5, columnspacing=1.2, borderaxespad=0.15)
    for line in legend.get_lines():
        line.set_linewidth(max(line.get_linewidth(), 1.8))

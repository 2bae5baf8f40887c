"""Figures of an evaluation: measured and predicted effort, and the error."""

import numpy as np

from .drawing import (draw_band, draw_expected, frame, legend, MEASURED, MODEL, panels, Picture,
                      Stroke, svg, zero_line)
from ..model.joints import JOINTS
from ..recordings.evaluation_results import Errors, Evaluation, Statistics

# Maximum number of intervals: a page with many recordings grows with each.
FINE, COARSE = 500, 200

# In the order of drawing. Lightness differs as well, for color-blind eyes and for paper.
STROKES = {
    'newton_euler': Stroke('Newton-Euler', '#a5cdea', 4.0),
    'measured': Stroke('measured', MEASURED, 1.8),
    'lagrange_euler': Stroke('Lagrange-Euler', MODEL),
}
_COINCIDE = 1e-9  # difference below which two methods are shown as one [N m]


def methods_of(of: Statistics) -> Errors:
    """Return the errors of the methods, without Newton-Euler if both coincide."""
    if len(of.methods) < 2:
        return of.methods
    first, second = of.methods.values()
    apart = max(np.abs(a - b).max() for a, b in zip(first[1:4], second[1:4]))
    return of.methods if apart > _COINCIDE else {'lagrange_euler': first}


def effort_picture(name: str, evaluation: Evaluation, joint: int, intervals: int) -> Picture:
    """
    Draw one joint of the paper's figures 5 to 7: measured and predicted effort, and the error.

    Without measured effort, draw the prediction alone. The number of intervals is FINE or COARSE.
    """
    time, methods = evaluation.time, methods_of(evaluation)
    figure, axes = panels((1.75, 1.05) if methods else (1.75,), JOINTS[joint])
    shown = {*methods, 'measured'} if methods else {'lagrange_euler'}
    for signal, stroke in STROKES.items():
        if signal in shown:
            draw_band(axes[0], time, evaluation.bands[signal], joint, stroke, intervals)
        if signal in methods:
            draw_band(axes[1], time, evaluation.bands['error_' + signal], joint, stroke,
                      intervals)
    frame(axes[0], 'effort [N m]')
    what = 'predicted'
    if methods:
        rms = f'RMS {methods["lagrange_euler"].rms[joint]:.3f} N m'
        what = f'measured and predicted, and their difference, {rms}'
        draw_expected(axes[1], time, evaluation.bands['deviation'].high[:, joint], intervals)
        zero_line(axes[1])
        axes[1].set_title(f'measured − predicted, {rms}', loc='left', pad=4)
        frame(axes[1], 'error [N m]')
    axes[-1].set_xlim(0.0, time[-1] + 0.5 * (time[1] - time[0]) if len(time) > 1 else 1.0)
    axes[-1].set_xlabel('time [s]', labelpad=2)
    legend(figure)
    return Picture(name, f'Effort at {JOINTS[joint]} over time: {what}', svg(figure))

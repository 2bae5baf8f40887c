"""Figures of the experiment: the paper's figure 5 and Table V."""

from __future__ import annotations

from baxter_dynamics_ros import JOINTS
from baxter_dynamics_ros.report.drawing import draw_band, FAINT, frame, zero_line
from baxter_dynamics_ros.simulation.trajectories import PERIODS
from matplotlib.figure import Figure
import numpy as np

from .sheet import drawn, legend, MODEL, OTHER, panels, TRUE, WRONG
from .table_five import evaluation, rows, SETS

_SHOWN = 3  # periods
# Label, color and width of each signal; lightness differs as well.
_SIGNALS = {'newton_euler': ('Newton-Euler', '#a5cdea', 4.0), 'measured': ('measured', OTHER, 1.8),
            'lagrange_euler': ('Lagrange-Euler', MODEL)}
_LEAST = 1e-5  # smaller values are drawn there [N m]
_DOT, _DASH = {'markersize': 5.5}, {'marker': '_', 'markersize': 13.0, 'markeredgewidth': 2.5}
_MARKS = {
    'paper, L-E': {'marker': 's', 'color': OTHER, **_DOT},
    'paper, RN-E': {'marker': 'D', 'color': TRUE, **_DOT},
    'ours, defaults': {'marker': 'o', 'color': MODEL, **_DOT},
    'ours, calibrated': {'marker': 'o', 'color': '#56b4e9', **_DOT},
    'RMS, defaults': {'color': WRONG, **_DASH},
    'RMS, calibrated': {'color': '#d89a83', **_DASH},
}
_TITLES = {'circle': '3(a) circle', 'switch': '3(b) switch', 'lift': '3(c) lift'}


@drawn
def circle() -> Figure:
    """Draw the paper's fig. 5 for the fake Baxter: efforts and errors, a row per joint."""
    found = evaluation('circle', False)
    figure, axes = panels(len(JOINTS), 2, 9.0, sharex=True)
    for joint, (left, right) in enumerate(axes):
        for signal, style in _SIGNALS.items():
            draw_band(left, found.time, found.bands[signal], joint, *style)
            if signal != 'measured':
                draw_band(right, found.time, found.bands['error_' + signal], joint, *style)
        zero_line(right)
        rms = found.methods['lagrange_euler'].rms[joint]
        right.set_title(f'RMS {rms:.3f} N m', loc='right', pad=2, color=FAINT, fontsize=9)
        frame(left, f'{JOINTS[joint]} [N m]')
        frame(right, '')
    axes[0, 0].set_title('effort', loc='left')
    axes[0, 1].set_title('measured − predicted', loc='left')
    for axis in axes[-1]:
        axis.set(xlabel='time [s]', xlim=(0.0, min(found.time[-1], _SHOWN * PERIODS['circle'])))
    figure.align_ylabels(axes[:, 0])
    legend(figure)
    return figure


@drawn
def table_five() -> Figure:
    """Draw Table V, the paper's and ours, and the RMS of the same errors."""
    figure, (axes,) = panels(1, 3, 4.2, sharey=True)
    for number, (axis, trajectory) in enumerate(zip(axes, SETS)):
        for name, values in rows(trajectory).items():
            axis.plot(JOINTS, np.maximum(np.abs(values), _LEAST), linestyle='', label=name,
                      **_MARKS[name])
        axis.set_yscale('log')
        axis.margins(x=0.06)
        axis.set_title(f'set {number + 1}, {_TITLES[trajectory]}')
    axes[0].set_ylabel('|signed mean| and RMS of e [N m]')
    legend(figure, columns=3)
    return figure

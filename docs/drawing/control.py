"""The picture of the control loop in docs/experiment.md, after the paper's fig. 2."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .sheet import FAINT, INK, MODEL, OTHER, styled, WIDTH, write

_HEIGHT = 2.6  # [in]


@styled
def control_loop(path: Path) -> None:
    """Draw the double loop of eqs. (13) and (14) over gravity and spring compensation."""
    figure = Figure(figsize=(WIDTH, _HEIGHT))
    axis = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axis.set_axis_off()
    axis.set_xlim(0.0, WIDTH)
    axis.set_ylim(0.0, _HEIGHT)
    line = 1.55  # height of the way from left to right [in]
    _box(axis, 1.0, 1.25, line, '$K_p\\,e + K_d\\,\\dot e$\n(13)', MODEL)
    _box(axis, 3.15, 1.35, line, '$K_p\\,\\dot\\epsilon + K_i\\,\\epsilon$\n(14)', MODEL)
    _box(axis, 5.45, 1.55, line, "Baxter's arm", INK)
    _box(axis, 4.55, 1.75, 2.28, 'gravity, springs', OTHER, 0.42)
    for x in (0.6, 2.75, 5.0):
        axis.plot(x, line, 'o', markersize=15, markerfacecolor='white', markeredgecolor=INK)
        axis.text(x, line, '+', ha='center', va='center', fontsize=12)
    _arrow(axis, (0.1, line), (0.5, line), '$q_r$')
    _arrow(axis, (0.7, line), (1.0, line), '$e$')
    _arrow(axis, (2.25, line), (2.65, line), '$\\dot q_r$')
    _arrow(axis, (2.85, line), (3.15, line), '$\\dot\\epsilon$')
    _arrow(axis, (4.5, line), (4.9, line), '$\\tau_r$')
    _arrow(axis, (5.0, 2.07), (5.0, line + 0.11))
    _arrow(axis, (5.1, line), (5.45, line))
    _arrow(axis, (7.0, line), (7.9, line), '$q,\\ \\dot q$')
    for x, down, label in ((7.55, 0.75, '$\\dot q$'), (7.25, 0.35, '$q$')):
        to = 2.75 if down > 0.5 else 0.6
        axis.plot([x, x, to], [line, down, down], color=FAINT, linewidth=1.2)
        _arrow(axis, (to, down), (to, line - 0.11))
        axis.text(to + 0.08, line - 0.3, '−', fontsize=12)
        axis.text(4.0 if down > 0.5 else 2.0, down + 0.06, label, fontsize=11)
    write(figure, path)


def _box(axis: Axes, left: float, width: float, middle: float, text: str, color: str,
         height: float = 0.72) -> None:
    """Draw a box with its text."""
    axis.fill([left, left + width, left + width, left],
              [middle - height / 2] * 2 + [middle + height / 2] * 2,
              facecolor='white', edgecolor=color, linewidth=1.6)
    axis.text(left + width / 2, middle, text, ha='center', va='center', fontsize=12, color=INK,
              linespacing=1.5)


def _arrow(axis: Axes, start: tuple[float, float], end: tuple[float, float],
           label: str = '') -> None:
    """Draw an arrow, and what goes along it above."""
    axis.annotate('', end, start, arrowprops={'arrowstyle': '-|>', 'color': FAINT, 'lw': 1.2,
                                              'shrinkA': 0.0, 'shrinkB': 0.0})
    axis.text((start[0] + end[0]) / 2, start[1] + 0.08, label, ha='center', fontsize=12)

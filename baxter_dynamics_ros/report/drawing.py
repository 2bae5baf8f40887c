"""Drawing shared by the figures: style, panels, ranges of signals, and SVG that stands alone."""

from contextlib import AbstractContextManager
import io
import re
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
import matplotlib.style
import numpy as np

from ..model import Array, BAND
from ..recordings.evaluation_results import Band

WIDTH = 4.6  # [in]: text of 9.5 pt stays above 9 px where this fills the width of a phone
_BOTTOM = 0.44  # margin of a figure [in]
_ROOM = 1.5  # height of a panel with the expected range, relative to that of the residuals
_SMALLEST = 0.005  # least half height of a panel [N m]: the resolution of effort
_GAP = 0.25  # time without samples that is shown as a gap; shorter is a low rate [s]

INK, FAINT, ALERT = '#1f2933', '#7b8794', '#a33b12'
MEASURED, MODEL, SHADE = '#e07b1a', '#0b3c68', '#e6eef6'
_TICKS, _GRID = '#3e4c59', '#e4e7eb'

# Color on a light page -> color on a dark one.
_DARK = {
    '#ffffff': '#12181f', INK: '#e4e7eb', FAINT: '#8b97a4', ALERT: '#ff9d73', _TICKS: '#b4bec9',
    _GRID: '#2b3440', MODEL: '#7cc0f5', MEASURED: '#f0923a', SHADE: '#22344a',
    '#bcd9ee': '#2b4a63', '#f0b79b': '#7a4630',
    '#b6c2ce': '#5d6c7b', '#56b4e9': '#3f78a3', '#d89a83': '#94543d'}

STYLE = {
    'font.family': 'DejaVu Sans',  # comes with matplotlib
    'font.size': 9.5,
    'axes.titlesize': 9.5,
    'text.color': INK,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.edgecolor': FAINT,
    'axes.labelcolor': INK,
    'xtick.color': _TICKS,
    'ytick.color': _TICKS,
    'axes.grid': True,
    'grid.color': _GRID,
    'axes.axisbelow': True,
    'svg.fonttype': 'path',  # looks alike wherever it is opened
    'svg.hashsalt': 'baxter_dynamics_ros',  # the same ids each time
}


def styled() -> AbstractContextManager[None]:
    """Return a context in which figures have this style, whatever the user's settings are."""
    return matplotlib.style.context(['default', STYLE])


class Picture(NamedTuple):
    """A finished figure."""

    name: str  # of its file, without folder and suffix
    description: str  # for readers who do not see it
    svg: bytes


def panels(heights: tuple[float, ...], title: str = '', left: float = 0.8,
           gap: float = 0.28, top: float = 0.34, sharex: bool = True
           ) -> tuple[Figure, list[Axes]]:
    """Return a figure and its panels, one above the other; all sizes in inches."""
    height = top + sum(heights) + gap * (len(heights) - 1) + _BOTTOM
    figure = Figure(figsize=(WIDTH, height))
    figure.text(0.012, 1.0 - 0.05 / height, title, va='top', fontsize=13, fontweight='bold')
    figure.subplots_adjust(left / WIDTH, _BOTTOM / height, 1.0 - 0.14 / WIDTH,
                           1.0 - top / height, hspace=gap * len(heights) / sum(heights))
    axes = figure.subplots(len(heights), sharex=sharex, squeeze=False, height_ratios=heights)
    for axis in axes.flat:
        axis.locator_params(axis='y', nbins=5, steps=[1, 2, 5, 10])
    return figure, axes[:, 0].tolist()


def legend(figure: Figure) -> None:
    """Put one legend of all panels above them, at the right."""
    entries = {label: handle for axis in figure.axes
               for handle, label in zip(*axis.get_legend_handles_labels())}
    figure.legend(list(entries.values()), list(entries), loc='upper right', frameon=False,
                  ncols=len(entries), handlelength=1.3, handletextpad=0.5, columnspacing=1.2,
                  borderaxespad=0.15)


def draw_band(axis: Axes, time: Array, band: Band, joint: int, label: str, color: str,
              width: float = 1.1) -> None:
    """Draw one joint of a signal: its range, and a line through the middle, broken at gaps."""
    time, low, high = _broken(time, band.low[:, joint], band.high[:, joint])
    axis.fill_between(time, low, high, color=color, alpha=0.5, linewidth=0.0)
    middle = 0.5 * (low + high)
    axis.plot(time, middle, color=color, linewidth=width, label=label)
    there = np.pad(np.isfinite(middle), 1)
    alone = there[1:-1] & ~there[:-2] & ~there[2:]  # between two gaps, where no line shows it
    axis.plot(time[alone], middle[alone], '.', color=color, markersize=width + 1.0)


def draw_expected(axis: Axes, time: Array, deviation: Array) -> None:
    """
    Shade the range in which 95 % of the residuals are expected, behind those drawn already.

    The deviation (n,) [N m] may be zero, if it is not known, or NaN. The range does not dwarf the
    residuals: it may reach beyond the panel.
    """
    time, limit, _ = _broken(time, BAND * deviation, deviation)
    if (limit > 0.0).any():  # false where NaN
        lower, upper = axis.get_ylim()
        axis.fill_between(time, -limit, limit, color=SHADE, linewidth=0.0, zorder=0.5,
                          label='expected (95 %)')
        reach = min(1.1 * np.nanmax(limit), _ROOM * max(-lower, upper))
        axis.set_ylim(min(lower, -reach), max(upper, reach))


def frame(axis: Axes, label: str, limits: tuple[float, float] | None = None) -> None:
    """Finish a panel: label and limits of y, not closer than the resolution of effort."""
    axis.set_ylabel(label)
    lower, upper = limits or axis.get_ylim()
    middle, half = 0.5 * (lower + upper), max(0.5 * (upper - lower), _SMALLEST)
    axis.set_ylim(middle - half, middle + half)
    if not any(np.isfinite(line.get_ydata()).any() for line in axis.lines):
        axis.text(0.5, 0.5, 'no samples', transform=axis.transAxes, ha='center', color=FAINT)


def zero_line(axis: Axes) -> None:
    """Mark zero, below the signals."""
    axis.axhline(0.0, color=INK, linewidth=0.6, zorder=1.5)


def svg(figure: Figure) -> bytes:
    """Return the figure as SVG that refers to nothing outside and follows the dark mode."""
    figure.align_ylabels()
    buffer = io.StringIO()
    FigureCanvasSVG(figure).print_svg(
        buffer, metadata=dict.fromkeys(('Date', 'Creator', 'Format', 'Type')))
    text = buffer.getvalue()
    text = text[text.index('<svg'):]  # without the document type, which names an address
    # Lines keep their width when the figure is enlarged.
    text = text.replace('stroke-linecap: butt}', 'stroke-linecap: butt; '
                        'vector-effect: non-scaling-stroke}', 1)
    rules = '\n'.join(f'[style*="{name}: {light}"] {{{name}: {dark} !important}}'
                      for light, dark in _DARK.items() for name in ('fill', 'stroke')
                      if f'{name}: {light}' in text)
    text = text.replace('</style>', f'@media (prefers-color-scheme: dark) {{{rules}}}</style>', 1)
    return re.sub(r'(?<= d=")[^"]*', _rounded, text).encode('utf-8')


def _rounded(path: re.Match[str]) -> str:
    """Return an SVG path with two decimals of a point instead of six, and fewer spaces."""
    numbers = re.sub(r'\d+\.\d{3,}', lambda number: f'{float(number[0]):.2f}', path[0])
    return re.sub(r'\s+(?=[MLQCz])', '', numbers)


def _broken(time: Array, low: Array, high: Array) -> tuple[Array, ...]:
    """Return the samples (n,) of a signal, with NaN where there are none for a while."""
    there = np.flatnonzero(np.isfinite(low))
    gaps = 1 + np.flatnonzero((np.diff(there) > 1) & (np.diff(time[there]) > _GAP))
    return tuple(np.insert(values[there], gaps, np.nan) for values in (time, low, high))

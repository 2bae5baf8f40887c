"""What the figures share: style, panels, bands of signals, and SVG that stands alone."""

from contextlib import AbstractContextManager
import io
import re
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
import matplotlib.style
from matplotlib.ticker import MaxNLocator
import numpy as np

from ..model.arrays import Array
from ..recordings.evaluation_results import Band

WIDTH = 4.6  # [in]: text of 9.5 pt stays above 9 px where this fills the width of a phone
_LEFT, _RIGHT = 0.74, 0.14  # margins [in]
_SMALLEST = 0.005  # [N m]: what is less is no more than the effort's resolution
# Without samples for longer than this, the stream handler starts anew [s]: a gap. What is shorter
# is no more than a low rate.
_GAP = 0.25

INK, FAINT, ALERT = '#1f2933', '#7b8794', '#a33b12'

STYLE = {
    'font.family': 'DejaVu Sans',  # comes with matplotlib
    'font.size': 9.5,
    'axes.titlesize': 9.5,
    'legend.fontsize': 9.5,
    'axes.spines.top': False,
    'axes.spines.right': False,
    'axes.edgecolor': FAINT,
    'axes.labelcolor': INK,
    'xtick.color': '#3e4c59',
    'ytick.color': '#3e4c59',
    'axes.grid': True,
    'grid.color': '#e4e7eb',
    'axes.axisbelow': True,
    'svg.fonttype': 'path',  # looks alike wherever it is opened
    'svg.hashsalt': 'baxter_dynamics_ros',  # the same ids each time
}


def styled() -> AbstractContextManager[None]:
    """Return a context in which figures have our style, whatever the user's settings are."""
    return matplotlib.style.context(['default', STYLE])


class Picture(NamedTuple):
    """A figure, drawn."""

    name: str  # of its file, without folder and ending
    description: str  # what it shows, for those who do not see it
    svg: bytes


class Stroke(NamedTuple):
    """How a signal is drawn."""

    label: str
    color: str
    width: float = 1.1  # [pt], and [px] on a page


def panels(title: str, time: Array, heights: tuple[float, ...],
           note: bool = False) -> tuple[Figure, list[Axes]]:
    """
    Return a figure and its panels, one above the other, over a recording's time.

    Parameters
    ----------
    title : str
        Top left, beside which there is room for a legend.
    time : ndarray (m,)
        Middles of the bands' intervals [s].
    heights : tuple of float
        Of each panel [in].
    note : bool
        Whether to leave room for a line above the first panel.

    """
    top, gap, bottom = 0.54 if note else 0.34, 0.28, 0.44  # [in]
    height = top + sum(heights) + gap * (len(heights) - 1) + bottom
    figure = sheet(title, height)
    axes, floor = [], height - top
    for panel in heights:
        floor -= panel
        axis = figure.add_axes(place(figure, _LEFT, floor, panel))
        axis.set_xlim(0.0, time[-1] + 0.5 * (time[1] - time[0]) if len(time) > 1 else 1.0)
        axis.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
        axis.yaxis.set_label_coords(-0.60 / (WIDTH - _LEFT - _RIGHT), 0.5)
        axis.tick_params(labelbottom=False)
        axes.append(axis)
        floor -= gap
    axes[-1].tick_params(labelbottom=True)
    axes[-1].set_xlabel('time [s]', labelpad=2)
    return figure, axes


def sheet(title: str, height: float) -> Figure:
    """Return an empty figure with a title, top left; height in inches."""
    figure = Figure(figsize=(WIDTH, height))
    figure.text(0.012, 1.0 - 0.05 / height, title, va='top', fontsize=13, fontweight='bold',
                color=INK)
    return figure


def place(figure: Figure, left: float, bottom: float, height: float,
          right: float = _RIGHT) -> tuple[float, float, float, float]:
    """Return a panel's place in parts of the figure; arguments in inches."""
    tall = figure.get_figheight()
    return (left / WIDTH, bottom / tall, (WIDTH - left - right) / WIDTH, height / tall)


def draw_band(axis: Axes, time: Array, band: Band, joint: int, stroke: Stroke,
              intervals: int) -> None:
    """Draw one joint of a band: what it spans, and a line through the middles, broken by gaps."""
    time, low, high = _merged(*_bridged(time, band, joint), intervals)
    middle = 0.5 * (low + high)
    if (high > low).any():  # false where NaN
        axis.fill_between(time, low, high, color=stroke.color, alpha=0.5, linewidth=0.0)
    axis.plot(time, middle, color=stroke.color, linewidth=stroke.width, label=stroke.label)
    there = np.concatenate([[False], np.isfinite(middle), [False]])
    alone = there[1:-1] & ~there[:-2] & ~there[2:]  # between two gaps, where no line shows it
    axis.plot(time[alone], middle[alone], '.', color=stroke.color, markersize=stroke.width + 1.0)


def span(band: Band, joint: int) -> tuple[float, float]:
    """Return the least and the greatest value of one joint; zeros where there is none."""
    low, high = band.low[:, joint], band.high[:, joint]
    if not np.isfinite(low).any():
        return 0.0, 0.0
    return float(np.nanmin(low)), float(np.nanmax(high))


def frame(axis: Axes, label: str, limits: tuple[float, float] | None = None) -> None:
    """
    Finish a panel: name and limits of its y axis, or a word where nothing is drawn.

    Limits that are not given follow from what is drawn, but are never closer than the effort's
    resolution: noise of 1e-15 is not for looking at.
    """
    axis.set_ylabel(label)
    lower, upper = limits or axis.get_ylim()
    middle, half = 0.5 * (lower + upper), max(0.5 * (upper - lower), _SMALLEST)
    axis.set_ylim(middle - half, middle + half)
    if not any(np.isfinite(line.get_ydata()).any() for line in axis.lines):
        axis.text(0.5, 0.5, 'no samples', transform=axis.transAxes, ha='center', color=FAINT)


def zero_line(axis: Axes) -> None:
    """Mark zero, below what is drawn."""
    axis.axhline(0.0, color=INK, linewidth=0.6, zorder=1.5)


def svg(figure: Figure) -> bytes:
    """Return the figure as SVG that refers to nothing outside of it."""
    buffer = io.StringIO()
    FigureCanvasSVG(figure).print_svg(
        buffer, metadata=dict.fromkeys(('Date', 'Creator', 'Format', 'Type')))
    text = buffer.getvalue()
    text = text[text.index('<svg'):]  # without the document type, which names an address
    # Enlarged, lines stay as thin as they are, so that more can be told apart.
    text = text.replace('stroke-linecap: butt}', 'stroke-linecap: butt; '
                        'vector-effect: non-scaling-stroke}', 1)
    return re.sub(r'(?<= d=")[^"]*', _compact, text).encode('utf-8')


def _compact(path: re.Match[str]) -> str:
    """Return an SVG path with two decimals of a point instead of six, and fewer spaces."""
    numbers = re.sub(r'-?\d+\.\d{3,}', lambda match: f'{float(match[0]):.2f}', path[0])
    return re.sub(r'\s+(?=[MLQCz])', '', numbers.strip())


def _bridged(time: Array, band: Band, joint: int) -> tuple[Array, Array, Array]:
    """Return time, low and high of one joint, without empty intervals that are not of a gap."""
    low, high = band.low[:, joint], band.high[:, joint]
    filled = np.flatnonzero(np.isfinite(low))
    after = np.searchsorted(filled, np.arange(len(time)))  # which filled one is here or next
    inside = np.flatnonzero((after > 0) & (after < len(filled)))
    hole = np.zeros(len(time))  # how long it is empty around here [s]
    hole[inside] = time[filled[after[inside]]] - time[filled[after[inside] - 1]]
    keep = np.isfinite(low) | (hole > _GAP)
    return time[keep], low[keep], high[keep]


def _merged(time: Array, low: Array, high: Array, intervals: int) -> tuple[Array, Array, Array]:
    """Return the same with neighbours merged to at most so many intervals."""
    each = -(-len(time) // intervals)
    if each <= 1:
        return time, low, high
    start = np.arange(0, len(time), each)
    # fmin and fmax: an interval is empty only where all that it is merged from are.
    return (np.add.reduceat(time, start) / np.diff(np.append(start, len(time))),
            np.fmin.reduceat(low, start), np.fmax.reduceat(high, start))

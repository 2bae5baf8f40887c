"""Style, colours and files of the figures."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

from baxter_dynamics_ros.report.drawing import ALERT, FAINT, INK, STYLE, svg
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
import numpy as np
from PIL import Image

WIDTH = 8.0  # [in]: a forge shows it about 800 px wide, text of 10 pt as 14 px

_STYLE = {**STYLE, 'font.size': 10.0, 'axes.titlesize': 10.5, 'legend.fontsize': 10.0}

_DPI = 150  # of PNG, for curves of many points
_SHADES = 64  # colours of it

# Told apart by lightness and width, too.
MODEL, OTHER, WRONG, TRUE = '#0b3c68', '#e07b1a', ALERT, '#b6c2ce'

__all__ = ['FAINT', 'INK', 'MODEL', 'OTHER', 'TRUE', 'WIDTH', 'WRONG', 'legend', 'panels',
           'styled', 'write']


def styled(draw: Callable[[Path], None]) -> Callable[[Path], None]:
    """Return a function that draws in this style, whatever matplotlib's settings are."""
    @wraps(draw)
    def draw_in_style(path: Path) -> None:
        with rc_context(_STYLE):
            draw(path)

    return draw_in_style


def panels(rows: int, columns: int, height: float, **options: Any) -> tuple[Figure, np.ndarray]:
    """
    Return a figure and its axes (rows, columns), which have room for a legend above.

    Parameters
    ----------
    rows, columns : int
        How many axes.
    height : float
        Of the figure [in].
    **options
        For ``Figure.subplots``.

    """
    figure = Figure(figsize=(WIDTH, height), layout='constrained')
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    for axis in np.ravel(axes):
        axis.margins(x=0.0)
    return figure, axes


def legend(figure: Figure, axis: Axes) -> None:
    """Put the legend of one axis above the figure, in one row."""
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside upper center', ncols=len(labels), frameon=False,
                  handlelength=1.6)


def write(figure: Figure, path: Path) -> None:
    """Write a figure as SVG that stands alone, or as PNG, by the ending: the same bytes always."""
    if path.suffix == '.png':
        figure.set_dpi(_DPI)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert('RGB')
        picture.quantize(_SHADES, dither=Image.Dither.NONE).save(path, optimize=True)
    else:
        path.write_bytes(svg(figure))

"""Style, colours and files of the figures."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any

from baxter_dynamics_ros.report.drawing import ALERT, MEASURED, MODEL, STYLE, svg
from matplotlib import rc_context
from matplotlib.figure import Figure
import numpy as np
from PIL import Image

WIDTH = 8.0  # [in]: shown about 800 px wide, text of 10 pt as 14 px
OTHER, WRONG, TRUE = MEASURED, ALERT, '#b6c2ce'  # lightness and width differ as well
_STYLE = {**STYLE, 'font.size': 10.0, 'axes.titlesize': 10.5, 'legend.fontsize': 10.0}
_DPI = 150  # of PNG, for curves of many points
_SHADES = 64  # colours of it

__all__ = ['MODEL', 'OTHER', 'TRUE', 'WRONG', 'drawn', 'legend', 'panels']


def drawn(draw: Callable[[], Figure]) -> Callable[[Path], None]:
    """Return a function that draws a figure in this style into a file, reproducibly."""
    @wraps(draw)
    def draw_into(path: Path) -> None:
        with rc_context(_STYLE):
            figure = draw()
            if path.suffix == '.svg':
                path.write_bytes(svg(figure))
                return
            figure.savefig(path, dpi=_DPI)
        picture = Image.open(path).convert('RGB')
        picture.quantize(_SHADES, dither=Image.Dither.NONE).save(path, optimize=True)

    return draw_into


def panels(rows: int, columns: int, height: float, **options: Any) -> tuple[Figure, np.ndarray]:
    """Return a figure of a height [in] and its axes (rows, columns)."""
    figure = Figure(figsize=(WIDTH, height), layout='constrained')
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    for axis in axes.flat:
        axis.margins(x=0.0)
    return figure, axes


def legend(figure: Figure, columns: int = 0) -> None:
    """Put the legend of the first axes above the figure."""
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc='outside upper center', ncols=columns or len(labels),
                  frameon=False, handlelength=1.6)

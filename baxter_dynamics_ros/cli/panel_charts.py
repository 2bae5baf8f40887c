"""Charts of the last 30 s, with scales that change rarely."""

from collections import deque
import math
from typing import Any

import numpy as np
import viser
from viser import uplot

from .monitor import Instant
from ..model.arrays import Array
from ..model.effort import BAND
from ..model.joints import JOINTS

WINDOW = 30.0  # [s]
_SMALLEST = 0.2  # height of a scale [N m]
_HEIGHT = 78  # [pixels]
_GRAY, _BLUE, _RED = '#8a949e', '#1f77c9', '#d1402b'
_CLEAR, _SHADE = 'rgba(0, 0, 0, 0)', 'rgba(31, 119, 201, 0.16)'


def steady_range(limits: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    """Return the limits, or wider or narrower ones if values leave them or fill less than 1/4."""
    height = limits[1] - limits[0]
    if limits[0] <= low and high <= limits[1] and (
            4.0 * (high - low) >= height or height <= _SMALLEST):
        return limits
    height = max(1.6 * (high - low), _SMALLEST)
    step = 10.0 ** math.floor(math.log10(height / 2.0))
    center = (low + high) / 2.0
    return (step * math.floor((center - height / 2.0) / step),
            step * math.ceil((center + height / 2.0) / step))


class Chart:
    """A chart of some series over the last 30 s."""

    def __init__(self, gui: viser.GuiApi, colors: tuple[str, ...], bands: Any = None,
                 is_last: bool = False) -> None:
        self._limits = (0.0, 0.0)
        self._handle = gui.add_uplot(
            tuple(np.zeros((1 + len(colors), 1))),
            ({}, *(uplot.Series(stroke=color, width=1.6, points={'show': False})
                   for color in colors)),
            bands=bands, scales={}, legend={'show': False}, cursor={'show': False},
            axes=(_axis(20 if is_last else 8, 60), _axis(44, 18)),
            height=_HEIGHT + 12 * is_last, padding=(6, 12, 0, 0))

    def update(self, time: Array, columns: tuple[Array, ...], symmetric: bool) -> None:
        """Show columns (n,) over time (n,) [s], on a scale that is symmetric to zero or not."""
        low, high = np.nanmin(columns), np.nanmax(columns)
        if symmetric:
            high = max(-low, high)
            low = -high
        limits = steady_range(self._limits, low, high)
        self._handle.data = (time, *columns)
        if limits != self._limits:
            self._limits = limits
            self._handle.scales = {'x': {'time': False, 'auto': False, 'range': (-WINDOW, 0.0)},
                                   'y': {'auto': False, 'range': limits}}


def _axis(size: int, space: int) -> uplot.Axis:
    stroke = _GRAY if size > 8 else _CLEAR  # no room for numbers
    return uplot.Axis(stroke=stroke, font='11px sans-serif', ticks={'show': False}, size=size,
                      space=space, grid={'stroke': 'rgba(138, 148, 158, 0.22)', 'width': 1})


class Charts:
    """Tabs with the residual and the effort of each joint."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._rows: deque[tuple[float, Array]] = deque()
        tabs = gui.add_tab_group()
        self._titles, self._residuals, self._efforts = [], [], []
        with tabs.add_tab('Residual'):
            gui.add_html(_caption(f'<i style="color:{_RED}">measured − predicted</i> effort in '
                                  'N m; the band holds 95 % of all residuals in free motion'))
            for joint in JOINTS:
                self._titles.append(gui.add_html(''))
                self._residuals.append(Chart(gui, (_CLEAR, _CLEAR, _RED), (
                    {'series': (1, 2), 'fill': _SHADE},), joint == JOINTS[-1]))
        with tabs.add_tab('Effort'):
            gui.add_html(_caption(f'<i style="color:{_GRAY}">measured</i> and '
                                  f'<i style="color:{_BLUE}">predicted</i> effort in N m'))
            for joint in JOINTS:
                gui.add_html(_title(joint, ''))
                self._efforts.append(Chart(gui, (_GRAY, _BLUE), None, joint == JOINTS[-1]))
        self.tabs = tabs

    def add(self, instant: Instant, now: float) -> None:
        """Add the efforts of an instant at monotonic time now [s]."""
        self._rows.append((now, np.array(instant)))
        while self._rows[0][0] < now - WINDOW:
            self._rows.popleft()

    def show(self, now: float) -> None:
        """Update all charts."""
        time = np.array([receipt for receipt, _ in self._rows]) - now
        measured, predicted, residual, deviation = np.moveaxis(
            np.array([row for _, row in self._rows]), 1, 0)
        band = BAND * deviation
        for i, joint in enumerate(JOINTS):
            if np.isfinite(predicted[:, i]).any():
                self._efforts[i].update(time, (measured[:, i], predicted[:, i]), False)
            if np.isfinite(residual[:, i]).any():
                self._residuals[i].update(
                    time, (band[:, i], -band[:, i], residual[:, i]), True)
            self._titles[i].content = _title(joint, _judged(residual[-1, i], band[-1, i]))


def _judged(residual: float, band: float) -> str:
    """Return a residual and its band as HTML."""
    if math.isnan(residual):
        return 'no residual'
    beyond = abs(residual) > band
    style = f'color:{_RED};font-weight:600' if beyond else ''
    expected = '' if math.isnan(band) else f'&ensp;expected ±{band:.2f}'
    return f'<span style="{style}">{residual:+.2f}</span>{expected}'


def _title(joint: str, text: str) -> str:
    return ('<div style="display:flex;justify-content:space-between;padding:2px 12px 0;'
            f'font-size:13px"><b>{joint}</b><span>{text}</span></div>')


def _caption(text: str) -> str:
    return f'<div style="padding:8px 12px 0;font-size:12px;opacity:0.75">{text}</div>'

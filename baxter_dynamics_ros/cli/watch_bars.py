"""Bars and sparklines as strings, in block characters or in ASCII."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
import math
import os


@dataclass(frozen=True)
class Glyphs:
    """What bars and sparklines are drawn with."""

    full: str
    left_half: str
    right_half: str
    track: str
    centre: str
    mark: str  # where another value lies
    below: str  # in place of a bar's end: it goes on beyond the scale
    above: str
    levels: str  # of a sparkline, from -scale to +scale
    ellipsis: str
    plus_minus: str


BLOCKS = Glyphs('█', '▌', '▐', '·', '│', '◆', '«', '»', '▁▂▃▄▅▆▇█', '…', '±')
ASCII = Glyphs('#', '-', '-', '.', '|', 'o', '<', '>', "_.-'^", '~', '')


def glyphs(encoding: str, environment: dict[str, str] | None = None) -> Glyphs:
    """
    Return what can be drawn in an encoding and a locale.

    In the C locale Python writes UTF-8 all the same (PEP 538 sets LC_CTYPE to C.UTF-8), but the
    terminal may not understand it.
    """
    environment = dict(os.environ) if environment is None else environment
    if not encoding.lower().replace('-', '').startswith('utf8'):
        return ASCII
    if {'PYTHONIOENCODING', 'PYTHONUTF8'} & environment.keys():
        return BLOCKS
    ctype = environment.get('LC_CTYPE', '')
    locale = (environment.get('LC_ALL') or ('' if ctype == 'C.UTF-8' else ctype)
              or environment.get('LANG') or 'C')
    return ASCII if locale in ('C', 'POSIX') else BLOCKS


def bar(value: float, scale: float, width: int, drawn: Glyphs, mark: float | None = None) -> str:
    """
    Return a bar of a value around a centre line.

    Parameters
    ----------
    value : float
        What the bar is as long as; NaN for none.
    scale : float
        What the end of the track stands for. What is beyond ends in an arrow.
    width : int
        Of the string; an odd number, at least 5.
    drawn : Glyphs
        What to draw with.
    mark : float, optional
        Another value, drawn as a single mark.

    """
    half = width // 2
    cells = [drawn.track] * width
    cells[half] = drawn.centre
    if not math.isnan(value):
        length = min(round(abs(value) / scale * 2 * half), 2 * half)  # in half cells
        step = 1 if value > 0.0 else -1
        for k in range(1, length // 2 + 1):
            cells[half + step * k] = drawn.full
        if length % 2:
            cells[half + step * (length // 2 + 1)] = (
                drawn.left_half if value > 0.0 else drawn.right_half)
        if abs(value) > scale:
            cells[half + step * half] = drawn.above if value > 0.0 else drawn.below
    if mark is not None and not math.isnan(mark):
        place = max(-half, min(half, round(mark / scale * half)))
        arrows = {drawn.below, drawn.above}
        if cells[half + place] in arrows and abs(mark) <= scale:
            place -= int(math.copysign(1, place))  # the arrow stays
        if abs(mark) <= scale:
            cells[half + place] = drawn.mark
        else:
            cells[half + place] = drawn.above if mark > 0.0 else drawn.below
    return ''.join(cells)


def sparkline(values: Iterable[float], scale: float, drawn: Glyphs) -> str:
    """Return values as a line of levels from -scale to +scale; blank where one is NaN."""
    top = len(drawn.levels) - 1

    def level(value: float) -> str:
        if math.isnan(value):
            return ' '
        return drawn.levels[max(0, min(top, math.floor((value / scale + 1.0) / 2.0 * (top + 1))))]
    return ''.join(level(value) for value in values)


def cropped(text: str, width: int, drawn: Glyphs) -> str:
    """Return a text that is no longer than width."""
    return text if len(text) <= width else text[:max(width - 1, 0)] + drawn.ellipsis[:width]

"""Figure of the architecture: a box a room, an arrow an import, from the table in the document."""

from __future__ import annotations

from pathlib import Path
import textwrap

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch
from rooms import Room, rooms

# Where the boxes are: left edge, lower edge, width; all are as high as HEIGHT.
PLACES = {
    'cli': (0.0, 7.7, 12.0),
    'report': (1.2, 5.8, 2.6), 'calibration': (4.3, 5.8, 2.4),
    'recordings': (1.2, 3.9, 3.7), 'nodes': (5.9, 3.9, 2.9), 'export': (9.6, 3.9, 2.4),
    'newton_euler': (0.0, 2.0, 2.3), 'estimation': (2.8, 2.0, 4.8), 'simulation': (8.0, 2.0, 4.0),
    'model': (0.0, 0.0, 8.0), 'files': (8.75, 0.0, 3.25)}
HEIGHT = 1.3
FACE, NUMPY_ALONE, EDGE = '#eef2f7', '#dcefe0', '#4a5a6a'
CAPTION = ('An arrow: imports. Dashed: late, when asked. Not drawn: all rooms import core, cli '
           'imports nearly all.\nGreen: NumPy and the standard library alone. In italics: the '
           'libraries that a room keeps to itself.')
OURS = ('model', 'estimation')  # import NumPy alone


def draw(path: Path) -> None:
    """Draw the rooms and their imports into a file."""
    table = rooms()
    if table.keys() != PLACES.keys():
        raise ValueError(f'give a place to {sorted(table.keys() ^ PLACES.keys())}')
    with matplotlib.rc_context({'svg.hashsalt': 'architecture', 'font.size': 9.0}):
        figure = Figure(figsize=(9.6, 7.2), facecolor='white')
        axes = figure.add_axes((0.01, 0.01, 0.98, 0.98))
        axes.set(xlim=(-0.1, 12.1), ylim=(-0.75, 9.1))
        axes.set_axis_off()
        for room in table.values():
            _box(axes, room)
        for room in table.values():
            if room.name != 'cli':
                _arrows(axes, room)
        axes.text(0.0, -0.55, CAPTION, va='center', color=EDGE)
        figure.savefig(path, metadata={'Date': None} if Path(path).suffix == '.svg' else None)


def _box(axes: Axes, room: Room) -> None:
    x, y, width = PLACES[room.name]
    axes.add_patch(FancyBboxPatch((x, y), width, HEIGHT, boxstyle='round,pad=0,rounding_size=0.1',
                                  facecolor=NUMPY_ALONE if room.name in OURS else FACE,
                                  edgecolor=EDGE))
    axes.text(x + 0.12, y + HEIGHT - 0.12, room.name, va='top', weight='bold')
    axes.text(x + width - 0.12, y + HEIGHT - 0.12, ', '.join(room.libraries), va='top', ha='right',
              style='italic', color=EDGE)
    lines = textwrap.wrap(room.text.replace('`', ''), int(width * 10.8))
    if len(lines) > 4:
        lines = textwrap.wrap(room.text.split(':')[0], int(width * 10.8))
    axes.text(x + 0.12, y + HEIGHT - 0.44, '\n'.join(lines), va='top', fontsize=8.5)


def _arrows(axes: Axes, room: Room) -> None:
    for names, style in ((room.imports, '-'), (room.late, '--')):
        for name in names:
            if name != 'model':
                axes.annotate('', _end(name, room.name), _end(room.name, name), arrowprops={
                    'arrowstyle': '-|>', 'color': EDGE, 'linestyle': style, 'shrinkA': 0,
                    'shrinkB': 0})


def _end(name: str, other: str) -> tuple[float, float]:
    """Return where an arrow between two boxes touches the first."""
    (x, y, width), (x2, y2, width2) = PLACES[name], PLACES[other]
    if y == y2:
        return (x + width if x2 > x else x), y + HEIGHT / 2
    left, right = max(x, x2), min(x + width, x2 + width2)
    return (left + right) / 2, (y if y2 < y else y + HEIGHT)

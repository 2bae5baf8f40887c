"""Display of running predictors: live on the screen, as lines, once, or as a figure."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import io
import math
import os
from pathlib import Path
import re
import select
import sys
import termios
import time
import tty

from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from .monitor import Monitor
from .terminal import printable, say, write
from .watch_view import line, view
from ..files import write_file
from ..model.exceptions import BaxterDynamicsError

_ENOUGH = 2.0  # [s] of predictions until rates and diagnostics are known
_LINE_PERIOD = 1.0  # [s]
_HELP = """\
residual  measured minus predicted effort
range     95 % of the residuals of free motion lie within it; red: beyond it
external  torque of the surroundings on the joint, estimated without acceleration
bold      joint in contact
q quits, ? hides this help"""


def live(monitor: Monitor, period: float, duration: float) -> None:
    """Redraw the view every period [s] until the duration [s] has passed or q is pressed."""
    with _keyboard() as pressed, Live(console=_console(), screen=True,
                                      auto_refresh=False) as screen:
        for now in monitor.ticks(period, duration, lambda: 'q' in pressed()):
            text = _HELP if pressed().count('?') % 2 else '? for help'
            screen.update(Group(_view(monitor, now), Text(text, 'dim')), refresh=True)


def lines(monitor: Monitor, duration: float) -> None:
    """Print a line per second and arm for a duration [s]."""
    for now in monitor.ticks(_LINE_PERIOD, duration):
        problem = monitor.problem(now)
        for text in [problem] if problem else [line(x, now) for x in monitor.shown(now)]:
            say(f'{time.strftime("%H:%M:%S")} {text}')


def once(monitor: Monitor, duration: float) -> None:
    """Print the view once data has arrived; raise BaxterDynamicsError if none does in time."""
    enough = math.inf
    for now in monitor.ticks(0.1, duration):
        shown = monitor.shown(now)
        if any(each.predicted.newest(now) for each in shown):
            enough = min(enough, now + _ENOUGH)
        if now >= enough and all(each.diagnostics(now) for each in shown):
            break
    if problem := monitor.problem(now, grace=0.0):
        raise BaxterDynamicsError(f'no data within {duration:g} s: {problem}')
    console = _console()
    with console.capture() as capture:
        console.print(_view(monitor, now))
    write(capture.get())


def save(monitor: Monitor, figure: Path) -> None:
    """Save the view as an SVG figure without web fonts."""
    console = Console(record=True, file=io.StringIO(), width=_console().width,
                      force_terminal=True, color_system='truecolor')
    console.print(_view(monitor, time.monotonic()))
    svg = re.sub(r'@font-face {.*?}\n', '', console.export_svg(title='baxter_dynamics watch'),
                 flags=re.DOTALL)
    write_file(figure, svg)
    say(f'figure: {figure}')


def _console() -> Console:
    return Console(markup=False, highlight=False, emoji=False)


def _view(monitor: Monitor, now: float) -> Group:
    problem = monitor.problem(now)
    heading = [Text(printable(problem), 'bold yellow')] if problem else []
    return Group(*heading, *(view(each, now) for each in monitor.shown(now)))


@contextmanager
def _keyboard() -> Iterator[Callable[[], str]]:
    """Read single keys without echo; yield a function that returns all that were pressed."""
    if sys.stdin is None or not sys.stdin.isatty():
        yield lambda: ''
        return
    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    keys = bytearray()

    def pressed() -> str:
        if select.select([descriptor], [], [], 0.0)[0]:
            keys.extend(os.read(descriptor, 100).lower())
        return keys.decode(errors='replace')
    try:
        yield pressed
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)

"""Display of running predictors: live on the screen, as lines, once, or as a figure."""

import argparse
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
from rich.table import Table
from rich.text import Text

from .monitor import effort_by_joint, Monitor, MonitoredPredictor
from .terminal import plain_console, say, show, table
from ..files import write_file
from ..model import BaxterDynamicsError, JOINTS, printable
from ..nodes import topics

_WAIT = 10.0  # [s] that --once waits by default
_ENOUGH = 2.0  # [s] of predictions until rates and diagnostics are known
_HALF = 10  # characters of a bar on either side of zero
_LEVELS = (('OK', 'green'), ('WARN', 'yellow'), ('ERROR', 'bold red'), ('STALE', 'magenta'))
_COLUMNS = ('joint', 'measured\n[N m]', 'predicted\n[N m]', 'residual\n[N m]',
            f'{"-range":<{_HALF}}0{"+range":>{_HALF}}', 'range\n[N m]', 'external\n[N m]')
_HELP = """\
residual  measured minus predicted effort
range     95 % of the residuals of free motion lie within it; red: beyond it
external  torque of the environment on the joint, estimated without acceleration
bold      joint in contact
q quits, ? hides this help"""


def watch(monitor: Monitor, args: argparse.Namespace) -> None:
    """Show predictors once, live on a terminal, or otherwise as a line per second and arm."""
    duration = args.duration or (_WAIT if args.once else math.inf)
    if args.once:
        _wait_for_data(monitor, duration)
        show(_view(monitor))
    elif sys.stdout is not None and sys.stdout.isatty():
        with _keyboard() as pressed, Live(console=plain_console(), screen=True,
                                          auto_refresh=False) as screen:
            for _ in monitor.ticks(1.0 / args.rate, duration, lambda: 'q' in pressed()):
                text = _HELP if pressed().count('?') % 2 else '? for help'
                screen.update(Group(_view(monitor), Text(text, 'dim')), refresh=True)
    else:
        for now in monitor.ticks(1.0, duration):
            problem = monitor.problem(now)
            for text in [problem] if problem else [line(x, now) for x in monitor.shown(now)]:
                say(f'{time.strftime("%H:%M:%S")} {text}')


def save(monitor: Monitor, figure: Path) -> None:
    """Save the view as an SVG figure without web fonts."""
    console = Console(record=True, file=io.StringIO(), width=plain_console().width,
                      force_terminal=True, color_system='truecolor')
    console.print(_view(monitor))
    svg = re.sub(r'@font-face {.*?}\n', '', console.export_svg(title='baxter_dynamics watch'),
                 flags=re.DOTALL)
    write_file(figure, svg)
    say(f'figure: {figure}')


def view(predictor: MonitoredPredictor, now: float) -> Group:
    """Return the view of a predictor at monotonic time now [s]."""
    style = {True: 'bold white on red', False: 'green', None: 'magenta'}[predictor.in_contact(now)]
    title = Text(printable(f'{predictor.name}  {predictor.side or "unknown"} arm  '), 'bold')
    diagnostics = Table(box=None, pad_edge=False, show_header=False)
    for name, level, text in predictor.diagnostics(now):
        diagnostics.add_row(printable(name), Text(*_LEVELS[level]), printable(text))
    if not diagnostics.row_count:
        diagnostics.add_row(Text('no diagnostics', 'magenta'))
    return Group(title.append(f' {predictor.contact(now)} ', style),
                 Text(predictor.rates(now)), _joint_table(predictor, now),
                 Text(printable(predictor.explanation(now)), 'bold'), diagnostics)


def line(predictor: MonitoredPredictor, now: float) -> str:
    """Return the state of a predictor in one line."""
    residual = predictor.efforts(now)[2]
    values = ' '.join(f'{joint} {_number(x)}' for joint, x in zip(JOINTS, residual))
    diagnostics = predictor.diagnostics(now)
    problems = ', '.join(f'{name} {_LEVELS[level][0]}' for name, level, _ in diagnostics if level)
    return '; '.join([
        f'{predictor.side or "unknown"} arm: {predictor.contact(now)}',
        'no residual' if math.isnan(residual[0]) else f'residual [N m] {values}',
        predictor.rates(now),
        problems or ('diagnostics OK' if diagnostics else 'no diagnostics')])


def bar(value: float, limit: float) -> str:
    """Return a bar that begins at zero in the middle and ends at the limit on either side."""
    is_known = math.isfinite(value) and limit > 0.0
    length = round(_HALF * min(abs(value) / limit, 1.0)) if is_known else 0
    left, right = (0, length) if value > 0.0 else (length, 0)
    return f'{"█" * left:>{_HALF}}│{"█" * right:<{_HALF}}'


def _view(monitor: Monitor) -> Group:
    now = time.monotonic()
    problem = monitor.problem(now)
    heading = [Text(printable(problem), 'bold yellow')] if problem else []
    return Group(*heading, *(view(each, now) for each in monitor.shown(now)))


def _joint_table(predictor: MonitoredPredictor, now: float) -> Table:
    result = table(_COLUMNS)
    touched = predictor.contact_joints(now)
    external = effort_by_joint(predictor.newest(topics.EXTERNAL_EFFORT, now))
    for joint, measured, predicted, residual, band, torque in zip(
            JOINTS, *predictor.efforts(now), external):
        style = 'bold red' if abs(residual) > band else ''
        result.add_row(joint, _number(measured), _number(predicted),
                       Text(_number(residual), style),
                       Text(bar(residual, band), style or 'cyan', justify='left'),
                       '-' if math.isnan(band) else f'±{band:.2f}', _number(torque),
                       style='bold' if joint in touched else '')
    return result


def _number(value: float) -> str:
    """Return a value as text, at most 9 characters; '-' if it is not finite."""
    if not math.isfinite(value):
        return '-'
    return f'{value:+.2f}' if abs(value) < 1e5 else f'{value:+.1e}'


def _wait_for_data(monitor: Monitor, duration: float) -> None:
    """Receive messages until the view is complete; raise BaxterDynamicsError without data."""
    complete = math.inf
    for now in monitor.ticks(0.1, duration):
        problem = monitor.problem(now, grace=0.0)
        complete = complete if problem else min(complete, now + _ENOUGH)
        if now >= complete and all(each.diagnostics(now) for each in monitor.shown(now)):
            break
    if problem:
        raise BaxterDynamicsError(f'no data within {duration:g} s: {problem}')


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

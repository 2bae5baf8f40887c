"""The view of a predictor: lines of text from what was heard, as many as there is room for."""

from __future__ import annotations

from dataclasses import dataclass
import sys
import textwrap

from rich.text import Text

from . import watch_words
from .watch_bars import bar, cropped, Glyphs, sparkline
from .watch_data import ArmData, BIN, Status, STATUS_STALE_AFTER, Watched
from ..estimation.contact import LIMIT
from ..model.joints import JOINTS

# What the ends of the bars stand for [N m]. Of the effort: somewhat more than it takes to hold
# and to move the arm. Of the residual: what a model that is not calibrated may be wrong by.
EFFORT_SCALE = (15.0, 40.0, 15.0, 20.0, 4.0, 5.0, 2.0)
RESIDUAL_SCALE = LIMIT
STATUSES = ('input', 'stamps', 'filter', 'effort', 'residual', 'external')

_STYLES = ('green', 'yellow', 'bold red', 'magenta')  # of the levels
_FINE = _STYLES[0]
_OLD = 'magenta'
_COLUMNS = (8, 10, 9, 9)  # of the numbers; the joint's name before them takes 2
_NUMBERS = 2 + sum(_COLUMNS)
_SCALES = (3, 4)  # columns behind the bars, that say what their ends stand for
_LEAST_BARS = 16  # columns; with fewer, the numbers stand alone
_LEAST_TRACE = 24  # columns of bars and sparkline together; with fewer, the bars stand alone
# What is tried until it fits: whether to leave lines free, to put the diagnostics in short, and
# to say what is wrong in full.
_LAYOUTS = ((True, False, True), (False, False, True), (False, False, False),
            (False, True, True), (False, True, False))


@dataclass(frozen=True)
class Canvas:
    """What there is to draw on; no height for as many lines as it takes."""

    width: int
    height: int | None
    glyphs: Glyphs

    def line(self, text: str, style: str = '') -> Text:
        """Return a line that is no longer than there is room."""
        return Text(cropped(text, self.width, self.glyphs), style=style)


def view(watched: Watched, side: str | None, title: str, missing: str | None, now: float,
         canvas: Canvas) -> list[Text]:
    """
    Return the lines of the view.

    Parameters
    ----------
    watched : Watched
        What was heard.
    side : str or None
        The only arm to show.
    title : str
        Stands on top.
    missing : str or None
        What is missing, and the remedy; None where nothing is.
    now : float
        Monotonic time [s].
    canvas : Canvas
        What to draw on.

    """
    arms = watched.shown(side)
    head = [canvas.line(title, 'bold')]
    if missing:
        head += [Text(line, style='bold yellow')
                 for line in textwrap.wrap(missing, canvas.width)]
    bodies = [_body(watched, arm, now, canvas) for arm in arms]
    lines: list[Text] = []
    height = sys.maxsize if canvas.height is None else canvas.height
    for roomy, in_short, in_full in _LAYOUTS:
        lines = head.copy()
        for arm, body in zip(arms, bodies):
            lines += _banner(arm, now, roomy, canvas) + body
        for arm in arms:
            lines += [Text()] * roomy + _diagnostics(arm, now, len(arms) > 1, in_short, in_full,
                                                     canvas)
        if len(lines) <= height:
            return lines
    hidden = len(lines) - height + 1
    return lines[:height - 1] + [canvas.line(
        f'{hidden} more lines: enlarge the terminal, or choose an --arm', 'dim')]


def _banner(arm: ArmData, now: float, roomy: bool, canvas: Canvas) -> list[Text]:
    """Return whether something touches the arm; three lines high where there is room."""
    words = f'{arm.side or "?"} arm: {watch_words.contact(arm, now)}'
    if not arm.contact_is_live(now):
        return [Text()] * roomy + [canvas.line(f' {words} ', f'reverse {_OLD}')]
    if not arm.contact:
        return [Text()] * roomy + [canvas.line(f' {words} ', 'black on green')]
    red = 'bold bright_white on red'
    edge = [canvas.line(' ' * canvas.width, red)] * roomy
    return edge + [canvas.line(f' *** {words} *** '.ljust(canvas.width), red)] + edge


def _body(watched: Watched, arm: ArmData, now: float, canvas: Canvas) -> list[Text]:
    lines = [canvas.line(watch_words.rates(watched, arm, now))]
    columns = _columns(canvas.width)
    lines.append(canvas.line(_heading(columns, canvas.glyphs), 'dim'))
    live = arm.instant() is not None and arm.residual.is_live(now)
    reason = '' if live else watch_words.why_no_residual(watched, arm, now)
    trace = arm.trace.extremes(columns[2], now)
    for i in range(len(JOINTS)):
        line = _numbers(arm, i, now)
        if live:
            _append_bars(line, arm, i, columns, canvas.glyphs)
            line.append(' ' + sparkline(trace[:, i], RESIDUAL_SCALE[i], canvas.glyphs), 'cyan')
        elif i == 0:
            line.append('  ' + reason, _OLD)
        line.truncate(canvas.width)
        lines.append(line)
    return lines


def _columns(width: int) -> tuple[int, int, int]:
    """Return the widths of effort bar, residual bar and sparkline; 0 for none of it."""
    left = width - _NUMBERS - sum(_SCALES) - 3
    if left < _LEAST_BARS:
        return 0, 0, 0
    trace = min(left // 3, 60) if left >= _LEAST_TRACE else 0
    residual = _odd(min((left - trace) // 2, 31))
    return _odd(min(left - trace - residual, 41)), residual, trace


def _odd(width: int) -> int:
    return width - 1 + width % 2


def _heading(columns: tuple[int, int, int], drawn: Glyphs) -> str:
    titles = ('measured', 'predicted', 'residual', 'external')
    text = '  ' + ''.join(title.rjust(width) for title, width in zip(titles, _COLUMNS))
    text = text[-_NUMBERS:]
    effort, residual, trace = columns
    if effort:
        text += (' ' + f'{drawn.full}meas {drawn.mark}pred'.center(effort).ljust(
            effort + _SCALES[0])) + ' ' + 'residual'.center(residual).ljust(residual + _SCALES[1])
    return text + (f' last {trace * BIN:g} s' if trace else '')


def _numbers(arm: ArmData, i: int, now: float) -> Text:
    """Return the joint's name and its numbers [N m]; in brackets where they are old."""
    is_live = arm.predicted.is_live(now), arm.residual.is_live(now), arm.external.is_live(now)
    instant = arm.instant()
    if instant is not None and is_live[1] >= is_live[0]:
        measured, predicted, residual = (values[i] for values in instant)
    else:  # predictions go on without a residual, so those of its last instant are past
        measured = residual = None
        predicted = None if arm.predicted.values is None else arm.predicted.values[i]
    external = None if arm.external.values is None else arm.external.values[i]
    line = Text(JOINTS[i])
    for value, live, width in ((measured, is_live[1], _COLUMNS[0]),
                               (predicted, is_live[0], _COLUMNS[1]),
                               (residual, is_live[1], _COLUMNS[2]),
                               (external, is_live[2], _COLUMNS[3])):
        if value is None:
            line.append('-'.rjust(width), 'dim')
        elif live:
            line.append(f'{value:+.2f}'.rjust(width))
        else:
            line.append(f'({value:+.1f})'.rjust(width), 'dim')
    return line


def _append_bars(line: Text, arm: ArmData, i: int, columns: tuple[int, int, int],
                 drawn: Glyphs) -> None:
    instant = arm.instant()
    if instant is None or not columns[0]:
        return
    measured, predicted, residual = (float(values[i]) for values in instant)
    line.append(' ' + bar(measured, EFFORT_SCALE[i], columns[0], drawn, mark=predicted), 'blue')
    line.append(f'{drawn.plus_minus}{EFFORT_SCALE[i]:g}'.ljust(_SCALES[0]), 'dim')
    line.append(' ' + bar(residual, RESIDUAL_SCALE[i], columns[1], drawn),
                'bold red' if abs(residual) > RESIDUAL_SCALE[i] else 'bold')
    line.append(f'{drawn.plus_minus}{RESIDUAL_SCALE[i]:g}'.ljust(_SCALES[1]), 'dim')


def _diagnostics(arm: ArmData, now: float, with_side: bool, in_short: bool, in_full: bool,
                 canvas: Canvas) -> list[Text]:
    """Return the statuses: in short, all that is well in one line; in full, what is not."""
    whose = f'{arm.side:<6}' if with_side else ''
    statuses = _statuses(arm, now)
    if in_short:
        fine = ', '.join(text.split()[0] for text, style in statuses if style == _FINE)
        statuses = [status for status in statuses if status[1] != _FINE]
        statuses += [(f'OK: {fine}', _FINE)] if fine else []
    lines = []
    for text, style in statuses:
        if in_full and style != _FINE:
            lines += [canvas.line(line, style) for line in textwrap.wrap(
                whose + text, canvas.width, subsequent_indent=' ' * (16 + len(whose)))]
        else:
            lines.append(canvas.line(whose + text, style))
    return lines


def _statuses(arm: ArmData, now: float) -> list[tuple[str, str]]:
    """Return a text and its style for each status."""
    if not arm.statuses:
        return [('no diagnostics heard', _OLD)]
    lines = []
    for name in STATUSES:
        status = arm.statuses.get(name, Status(3, 'not heard', {}, now))
        level, style = watch_words.level_word(status.level), _STYLES[min(status.level, 3)]
        if now - status.heard > STATUS_STALE_AFTER:
            level, style = f'{level}, {watch_words.age(now - status.heard)} ago:', _OLD
        lines.append((f'{name:<9}{level:<6} {status.message}', style))
    return lines

"""View of a predictor, as a table or a line."""

import math

from rich.box import SIMPLE_HEAD
from rich.console import Group
from rich.table import Table
from rich.text import Text

from .monitor import Predictor
from .terminal import printable
from ..model.effort import BAND
from ..model.joints import JOINTS

BAR = 10  # characters on either side of zero
_LEVELS = (('OK', 'green'), ('WARN', 'yellow'), ('ERROR', 'bold red'), ('STALE', 'magenta'))
_COLUMNS = ('joint', 'measured\n[N m]', 'predicted\n[N m]', 'residual\n[N m]',
            f'{"-range":<{BAR}}0{"+range":>{BAR}}', 'range\n[N m]', 'external\n[N m]')


def view(predictor: Predictor, now: float) -> Group:
    """Return the view of a predictor at monotonic time now [s]."""
    style = {True: 'bold white on red', False: 'green', None: 'magenta'}[predictor.in_contact(now)]
    title = Text(printable(f'{predictor.name}  {predictor.side or "unknown"} arm  '), 'bold')
    return Group(title.append(f' {contact_text(predictor, now)} ', style),
                 Text(rates_text(predictor, now)), _joint_table(predictor, now),
                 Text(printable(predictor.explanation(now)), 'bold'),
                 _diagnostics_table(predictor, now))


def line(predictor: Predictor, now: float) -> str:
    """Return the state of a predictor in one line."""
    residual = predictor.instant(now).residual
    values = ' '.join(f'{joint} {number(x)}' for joint, x in zip(JOINTS, residual))
    diagnostics = predictor.diagnostics(now)
    problems = ', '.join(f'{status.name} {_level(status.level)[0]}' for status in diagnostics
                         if status.level)
    return (f'{predictor.side or "unknown"} arm: {contact_text(predictor, now)}; '
            + ('no residual' if math.isnan(residual[0]) else f'residual [N m] {values}')
            + f'; {rates_text(predictor, now)}; '
            + (problems or ('diagnostics OK' if diagnostics else 'no diagnostics')))


def bar(value: float, limit: float) -> str:
    """Return a bar that begins at zero in the middle and ends at the limit on either side."""
    is_known = math.isfinite(value) and limit > 0.0
    length = round(BAR * min(abs(value) / limit, 1.0)) if is_known else 0
    left, right = (0, length) if value > 0.0 else (length, 0)
    return f'{"█" * left:>{BAR}}│{"█" * right:<{BAR}}'


def number(value: float) -> str:
    """Return a value as text, at most 9 characters; '-' if it is not finite."""
    if not math.isfinite(value):
        return '-'
    return f'{value:+.2f}' if abs(value) < 1e5 else f'{value:+.1e}'


def contact_text(predictor: Predictor, now: float) -> str:
    """Return the state of contact: joints and duration."""
    in_contact = predictor.in_contact(now)
    if not in_contact:
        return 'contact unknown' if in_contact is None else 'no contact'
    joints = ', '.join(predictor.contact_joints(now)) or 'joints not yet known'
    return f'CONTACT for {predictor.contact_duration(now):.1f} s: {joints}'


def rates_text(predictor: Predictor, now: float) -> str:
    """Return the rates of the topics, and the delay of the residual."""
    delay = predictor.delay(now)
    return ', '.join([
        f'predictions {predictor.predicted.rate(now):.1f} Hz',
        f'residuals {predictor.residual.rate(now):.1f} Hz',
        f'joint states {predictor.joint_states.rate(now):.1f} Hz',
        *([] if delay is None else [f'delay {1e3 * delay:.0f} ms'])])


def _joint_table(predictor: Predictor, now: float) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for title in _COLUMNS:
        table.add_column(title, justify='right' if '[' in title else 'left', no_wrap=True)
    external = predictor.external.newest(now)
    externals = external[1] if external else [math.nan] * len(JOINTS)
    touched = predictor.contact_joints(now)
    for joint, measured, predicted, residual, deviation, force in zip(
            JOINTS, *predictor.instant(now), externals):
        band = BAND * deviation
        style = 'bold red' if abs(residual) > band else ''
        table.add_row(joint, number(measured), number(predicted), Text(number(residual), style),
                      Text(bar(residual, band), style or 'cyan'),
                      '-' if math.isnan(band) else f'±{band:.2f}', number(force),
                      style='bold' if joint in touched else '')
    return table


def _diagnostics_table(predictor: Predictor, now: float) -> Table:
    table = Table(box=None, pad_edge=False, show_header=False)
    for status in predictor.diagnostics(now):
        word, style = _level(status.level)
        table.add_row(printable(status.name), Text(word, style), printable(status.message))
    if not table.row_count:
        table.add_row(Text('no diagnostics', 'magenta'))
    return table


def _level(level: int) -> tuple[str, str]:
    return _LEVELS[level] if level < len(_LEVELS) else (f'level {level}', 'magenta')

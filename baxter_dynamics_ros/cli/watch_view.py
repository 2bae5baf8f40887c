"""View of a predictor, as a table or a line."""

from __future__ import annotations

from rich.box import SIMPLE_HEAD
from rich.console import Group
from rich.table import Table
from rich.text import Text

from .printing import printable
from .watch_data import by_joint, Predictor
from ..estimation.contact import LIMIT
from ..model.joints import JOINTS

BAR = 10  # characters on either side of zero
_LEVELS = (('OK', 'green'), ('WARN', 'yellow'), ('ERROR', 'bold red'), ('STALE', 'magenta'))
_COLUMNS = ('joint', 'measured\n[N m]', 'predicted\n[N m]', 'residual\n[N m]',
            f'{"-limit":<{BAR}}0{"+limit":>{BAR}}', 'limit\n[N m]', 'external\n[N m]')


def view(predictor: Predictor, now: float) -> Group:
    """Return the view of a predictor at monotonic time now [s]."""
    style = {True: 'bold white on red', False: 'green', None: 'magenta'}[_contact(predictor, now)]
    title = Text(printable(f'{predictor.name}  {predictor.side or "unknown"} arm  '), 'bold')
    return Group(title.append(f' {contact_text(predictor, now)} ', style),
                 Text(rates_text(predictor, now)), _joint_table(predictor, now),
                 _diagnostics_table(predictor, now))


def line(predictor: Predictor, now: float) -> str:
    """Return the state of a predictor in one line."""
    instant = predictor.instant(now)
    residual = 'no residual' if instant is None else 'residual [N m] ' + ' '.join(
        f'{joint} {number(instant.residual.get(joint))}' for joint in JOINTS)
    levels = [f'{name} {_level(level)[0]}' for name, level, _ in predictor.diagnostics(now)
              if level]
    diagnostics = ', '.join(levels) or (
        'diagnostics OK' if predictor.diagnostics(now) else 'no diagnostics')
    return (f'{predictor.side or "unknown"} arm: {contact_text(predictor, now)}; {residual}; '
            f'{rates_text(predictor, now)}; {diagnostics}')


def bar(value: float, limit: float) -> str:
    """Return a bar that begins at zero in the middle and ends at the limit on either side."""
    length = round(BAR * min(abs(value) / limit, 1.0))
    left, right = (0, length) if value > 0.0 else (length, 0)
    return f'{"█" * left:>{BAR}}│{"█" * right:<{BAR}}'


def number(value: float | None) -> str:
    """Return a value as text, at most 9 characters; '-' for None."""
    if value is None:
        return '-'
    return f'{value:+.2f}' if abs(value) < 1e5 else f'{value:+.1e}'


def contact_text(predictor: Predictor, now: float) -> str:
    """Return the state of contact: joints and duration."""
    contact = _contact(predictor, now)
    if contact is None:
        return 'contact unknown'
    if not contact:
        return 'no contact'
    joints = ', '.join(predictor.contact_joints()) or 'joints not yet known'
    return f'CONTACT for {predictor.contact_duration(now):.1f} s: {joints}'


def rates_text(predictor: Predictor, now: float) -> str:
    """Return the rates of the topics, and the delay of the residual."""
    delay = predictor.delay(now)
    return ', '.join([
        f'predictions {predictor.predicted.rate(now):.1f} Hz',
        f'residuals {predictor.residual.rate(now):.1f} Hz',
        f'joint states {predictor.joint_states.rate(now):.1f} Hz',
        *([] if delay is None else [f'delay {1e3 * delay:.0f} ms'])])


def _contact(predictor: Predictor, now: float) -> bool | None:
    message = predictor.contact.newest(now)
    return None if message is None else bool(message.data)


def _joint_table(predictor: Predictor, now: float) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for title in _COLUMNS:
        table.add_column(title, justify='right' if '[' in title else 'left', no_wrap=True)
    instant = predictor.instant(now)
    predicted, external = predictor.predicted.newest(now), predictor.external.newest(now)
    measured, residuals = ({}, {}) if instant is None else (instant.measured, instant.residual)
    # With a residual, all three are of the same instant; without one, predictions go on.
    predictions = instant.predicted if instant else by_joint(predicted) if predicted else {}
    externals = by_joint(external) if external else {}
    touched = predictor.contact_joints() if _contact(predictor, now) else []
    for joint, limit in zip(JOINTS, LIMIT):
        residual = residuals.get(joint)
        style = '' if residual is None or abs(residual) <= limit else 'bold red'
        table.add_row(
            joint, number(measured.get(joint)), number(predictions.get(joint)),
            Text(number(residual), style),
            Text('' if residual is None else bar(residual, limit), style or 'cyan'),
            f'±{limit:g}', number(externals.get(joint)),
            style='bold' if joint in touched else '')
    return table


def _diagnostics_table(predictor: Predictor, now: float) -> Table:
    table = Table(box=None, pad_edge=False, show_header=False)
    for name, level, message in predictor.diagnostics(now):
        word, style = _level(level)
        table.add_row(printable(name), Text(word, style), printable(message))
    if not table.row_count:
        table.add_row(Text('no diagnostics', 'magenta'))
    return table


def _level(level: int) -> tuple[str, str]:
    return _LEVELS[level] if level < len(_LEVELS) else (f'level {level}', 'magenta')

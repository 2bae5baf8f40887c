"""The table of a comparison: as text, as Markdown, as JSON."""

from dataclasses import asdict
from importlib import metadata
import json
from pathlib import Path
import platform

from .comparison import BATCH, GROWTH
from .targets import verdicts

PACKAGES = ('numpy', 'numba', 'pin', 'mujoco', 'pybullet', 'drake', 'roboticstoolbox-python',
            'casadi')
TITLES = {  # of a section, by call
    'tau': 'tau, one state',
    'split': 'M, C qd and G, one state',
    'matrices': 'M, C and G, one state',
    'forward': 'forward dynamics, one state',
    BATCH: 'tau, batch of',
    GROWTH: 'tau, growing batches:',
}
COLUMNS = ('', 'us a state', 'least', 'ratio', 'difference', 'extra MB', '')
TARGET_COLUMNS = ('target', 'bound', 'measured', 'by BaxterArm', '')


def header() -> dict:
    """Return what the numbers depend on: the processor and the versions."""
    versions = {}
    for name in PACKAGES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            pass
    return {'processor': _processor(), 'python': platform.python_version(), 'threads': 1,
            'versions': versions}


def as_text(rows: list, batch: int) -> str:
    """Return all of it as text for a terminal."""
    titles, sections = zip(*_sections(rows))
    lines = iter(_aligned([COLUMNS, *(line for section in sections for line in section)]))
    parts = [_explanation(), '', next(lines)]
    for title, section in zip(titles, sections):
        parts += ['', title, *(next(lines) for _ in section)]
    return '\n'.join([*parts, '', *_aligned([TARGET_COLUMNS, *verdicts(rows, batch)])])


def as_markdown(rows: list, batch: int) -> str:
    """Return all of it as Markdown."""
    lines = [COLUMNS]
    for title, section in _sections(rows):
        lines += [(f'**{title}**', *[''] * (len(COLUMNS) - 1)), *section]
    targets = [TARGET_COLUMNS, *verdicts(rows, batch)]
    return '\n\n'.join([_explanation(), _piped(lines), _piped(targets)])


def as_json(rows: list, batch: int) -> str:
    """Return all of it as JSON; times in s, memory in bytes, differences in N m."""
    names = ('target', 'bound', 'measured', 'checked', 'verdict')
    return json.dumps({
        'header': header(), 'rows': [asdict(row) for row in rows],
        'targets': [dict(zip(names, verdict)) for verdict in verdicts(rows, batch)]}, indent=2)


def _explanation() -> str:
    about = header()
    versions = ', '.join(f'{name} {version}' for name, version in about['versions'].items())
    return (f"{about['processor']}, Python {about['python']}, one thread; {versions}.\n"
            'Medians of runs that take turns. Ratio: for one state the time over that of '
            "Pinocchio's rnea, less is\nbetter; for a batch the rate over that of its "
            'rneaInParallel on one thread, more is better; for growing\nbatches the time a state '
            'over that in the smallest. Difference: the largest in a torque, from the\nequations '
            'as printed [N m]. Extra MB: beyond arguments and result.')


def _sections(rows: list):
    """Yield (title, lines) of each section."""
    for call, title in TITLES.items():
        for size in sorted({row.size for row in rows if row.call == call}):
            lines = [_cells(row) for row in rows if (row.call, row.size) == (call, size)]
            yield f'{title} {size:,}' if size > 1 else title, lines


def _cells(row) -> tuple:
    def text(value, form, scale=1.0):
        return '-' if value is None else format(value * scale, form)

    return (row.engine, text(row.seconds, '.3f', 1e6), text(row.best, '.3f', 1e6),
            text(row.ratio, '.2f'), text(row.difference, '.0e'), text(row.memory, '.1f', 1e-6),
            row.note)


def _aligned(lines: list) -> list:
    """Return lines of cells as texts in columns: words to the left, numbers to the right."""
    widths = [max(map(len, column)) for column in zip(*lines)]
    left = [not any(cell[:1].isdigit() for cell in column) for column in zip(*lines)]
    return ['  '.join(
        cell.ljust(width) if is_left else cell.rjust(width)
        for cell, width, is_left in zip(line, widths, left)).rstrip() for line in lines]


def _piped(lines: list) -> str:
    head, *body = ('| ' + ' | '.join(line) + ' |' for line in lines)
    return '\n'.join([head, '|---' * len(lines[0]) + '|', *body])


def _processor() -> str:
    try:
        for line in Path('/proc/cpuinfo').read_text(encoding='utf-8').splitlines():
            if line.startswith('model name'):
                return line.partition(':')[2].strip()
    except OSError:
        pass  # not Linux
    return platform.processor() or platform.machine()

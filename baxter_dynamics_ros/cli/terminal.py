"""Text, tables and progress bars; text from outside is never interpreted by the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
import io
import os
import signal
import sys
from typing import Any, TYPE_CHECKING

from ..model import BaxterDynamicsError, printable

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table


def say(*lines: object) -> None:
    """Print lines to stdout; see :func:`.printable` and :func:`write`."""
    write('\n'.join(map(printable, lines)) + '\n')


def complain(line: str) -> None:
    """Print a line to stderr; see :func:`.printable`."""
    print(printable(line), file=sys.stderr)


def write(text: str) -> None:
    """Write a text to stdout as it is; characters that the encoding lacks are escaped."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors='backslashreplace')
    try:
        print(text, end='', flush=True)
    except OSError as error:
        # The buffer would be written again at exit, with a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            raise SystemExit(128 + signal.SIGPIPE) from None
        raise BaxterDynamicsError(f'standard output: {error.strerror}') from None


def plain_console() -> Console:
    """Return a console that prints text as it is, with '?' for what the encoding lacks."""
    from rich.console import Console
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors='replace')
    return Console(markup=False, highlight=False, emoji=False)


def show(content: RenderableType) -> None:
    """Print a rich renderable."""
    console = plain_console()
    with console.capture() as capture:
        console.print(content)
    write(capture.get())


def table(columns: Sequence[str]) -> Table:
    """Return a table without rows; all columns but the first are aligned to the right."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Column, Table
    return Table(Column(columns[0], no_wrap=True),
                 *(Column(column, justify='right') for column in columns[1:]),
                 box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))


def show_table(columns: Sequence[str], rows: Iterable[Sequence[Any]], decimals: int = 3,
               bold_last: bool = False) -> None:
    """Print a table of texts and numbers; see :func:`table`."""
    result = table(columns)
    for row in rows:
        result.add_row(*(f'{cell:.{decimals}f}' if isinstance(cell, float) else printable(cell)
                         for cell in row))
    if bold_last:
        result.rows[-1].style = 'bold'
    show(result)


@contextmanager
def progress(total: float | None = None) -> Iterator[Callable[[float, str], None]]:
    """Show a bar, which moves without a total; yield a function of amount and description."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
    console = Console()
    with Progress(TextColumn('{task.description}', markup=False), BarColumn(),
                  TimeRemainingColumn(), console=console, transient=True,
                  disable=not console.is_terminal) as bar:
        task = bar.add_task('', total=total)
        yield lambda completed, text: bar.update(task, completed=completed,
                                                 description=printable(text))

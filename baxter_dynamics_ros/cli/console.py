"""Tables and progress bars on the terminal, without markup."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeRemainingColumn
from rich.table import Table

from .printing import printable, write


def show_table(columns: Sequence[str], rows: Sequence[Sequence[str]],
               bold_last: bool = False) -> None:
    """Print a table; all columns but the first are aligned to the right."""
    result = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for i, column in enumerate(columns):
        result.add_column(column, justify='right' if i else 'left', no_wrap=not i)
    for i, row in enumerate(rows):
        result.add_row(*map(printable, row),
                       style='bold' if bold_last and i == len(rows) - 1 else None)
    console = Console(markup=False, highlight=False, emoji=False)
    with console.capture() as capture:
        console.print(result)
    write(capture.get())


@contextmanager
def progress(total: float | None = None) -> Iterator[Callable[[float, str], None]]:
    """
    Show a progress bar, or without a total a spinner, if stdout is a terminal.

    Yields a function to call with the amount completed and a description.
    """
    console = Console()
    columns = [SpinnerColumn(), TextColumn('{task.description}', markup=False)]
    if total is not None:
        columns += [BarColumn(), TimeRemainingColumn()]
    with Progress(*columns, console=console, transient=True,
                  disable=not console.is_terminal) as bar:
        task = bar.add_task('', total=total)
        yield lambda completed, text: bar.update(task, completed=completed,
                                                 description=printable(text))

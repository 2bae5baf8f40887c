"""Tables as data, which the template macro shows."""

from collections.abc import Sequence
from itertools import groupby
from typing import Any, NamedTuple

from .number_text import number
from ..model.arrays import Array


class Column(NamedTuple):
    """One column of a table."""

    label: str
    values: Array | Sequence[str]  # (n,)
    group: str = ''  # heading shared with neighbors
    digits: int = 3
    whole: 'Array | float | None' = None  # (n,) or for all: value of a bar of full length
    foot: 'float | None' = None  # value in the last row

    def text(self, index: int) -> str:
        """Return the text of a cell."""
        value = self.values[index]
        return value if isinstance(value, str) else number(value, self.digits)

    def bar(self, index: int) -> 'float | None':
        """Return the relative length of a cell's bar, 0 to 1; None without a bar."""
        if self.whole is None:
            return None
        whole = self.whole if isinstance(self.whole, float) else self.whole[index]
        part = abs(float(self.values[index])) / whole if whole > 0.0 else 0.0
        return min(part, 1.0) if part == part else 0.0  # not NaN


class Table(NamedTuple):
    """A table; the bars behind numbers compare columns or rows."""

    caption: str
    corner: str  # heading of the rows' names
    rows: Sequence[Any]  # names: str, or (str, address within the page)
    columns: Sequence[Column]
    foot: str = ''  # name of the last row

    @property
    def groups(self) -> list[tuple[str, int]]:
        """Return (heading, number of columns) of neighbors; empty without headings."""
        if not any(column.group for column in self.columns):
            return []
        return [(group, len(list(columns)))
                for group, columns in groupby(self.columns, key=lambda column: column.group)]

    def starts_group(self, index: int) -> bool:
        """Return whether a column is the first one below its heading."""
        group = self.columns[index].group
        return bool(group) and (index == 0 or self.columns[index - 1].group != group)

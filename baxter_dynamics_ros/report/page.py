"""Parts of both reports: numbers as text, tables, findings, and the rendering of a page."""

import base64
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import compress, groupby
import math
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
import numpy as np

from .drawing import Picture
from .. import __version__
from ..model import Array, JOINTS


def number(value: float, digits: int = 3) -> str:
    """Return a number with a number of decimals, or a dash if it is not finite."""
    if not math.isfinite(value):
        return '–'
    text = f'{value:.{digits}f}' if value else '0'
    return text.lstrip('-') if float(text) == 0.0 else text.replace('-', '−')


def torque(value: float) -> str:
    """Return a torque with its unit."""
    return f'{number(value, 2)}\u00a0N\u00a0m'


def decimals(deviation: float) -> int:
    """Return the number of significant decimals: two digits of the standard deviation."""
    if not 0.0 < deviation < math.inf:
        return 4
    return min(max(1 - math.floor(math.log10(deviation)), 0), 6)


def plus_minus(value: float, deviation: float, unit: str) -> str:
    """Return a number with its standard deviation and unit."""
    digits = decimals(deviation)
    text = f'{number(value, digits)} ± {number(deviation, digits)} {unit}'
    return text.rstrip().replace(' ', '\u00a0')


def change(before: float, after: float) -> str:
    """Return a relative change in percent, or as a factor if it is above ten."""
    if not (before > 0.0 and math.isfinite(after)):
        return '–'
    if after > 10.0 * before:
        return f'×\u00a0{after / before:.0f}'
    percents = round(100.0 * (after / before - 1.0))
    return f'{percents:+d}\u00a0%'.replace('-', '−').replace('+0\u00a0', '0\u00a0')


def duration(seconds: float) -> str:
    """Return a duration in seconds, or in minutes and seconds."""
    if seconds < 120.0:
        return f'{seconds:.1f} s'
    return f'{round(seconds) // 60} min {round(seconds) % 60} s'


class Column(NamedTuple):
    """One column of a table."""

    label: str
    values: Array | Sequence[str]  # (n,)
    group: str = ''  # heading shared with neighbors
    digits: int = 3
    whole: Any = None  # value of a bar of full length, for all or (n,); None: no bars

    def text(self, index: int) -> str:
        """Return the text of a cell."""
        value = self.values[index]
        return value if isinstance(value, str) else number(value, self.digits)

    def bar(self, index: int) -> float:
        """Return the relative length of a cell's bar, 0 to 1."""
        parts = np.abs(self.values) / np.maximum(self.whole, 1e-9)
        return min(float(np.nan_to_num(parts)[index]), 1.0)


class Table(NamedTuple):
    """A table; the bars behind numbers compare columns or rows."""

    caption: str
    columns: Sequence[Column]
    corner: str = 'joint'  # heading of the rows' names
    rows: Sequence[str] = JOINTS  # names
    foot: bool = False  # whether the last row is about the others
    address: str = ''  # of a row within the page, to which its number is added

    @property
    def groups(self) -> list[tuple[str, int]]:
        """Return (heading, number of columns) of neighbors."""
        return [(group, len(list(columns)))
                for group, columns in groupby(self.columns, key=lambda column: column.group)]


def joint_columns(values: Iterable[Array]) -> list[Column]:
    """Return a column per joint, with bars that compare its rows, for values (n, 7)."""
    return [Column(joint, column, whole=float(np.fmax.reduce(column)))
            for joint, column in zip(JOINTS, np.transpose([*values]))]


def compared(columns: Mapping[str, Array]) -> list[Column]:
    """Return columns (n,) by label, with bars that compare the columns of a row."""
    whole = np.max([*columns.values()], axis=0)
    return [Column(label, values, whole=whole) for label, values in columns.items()]


def findings(rules: Mapping[str, Callable[[Any], 'str | None']], of: Any) -> dict[str, str]:
    """Return the sentence of each rule that finds something in the results, by topic."""
    return {topic: text for topic, rule in rules.items() if (text := rule(of))}


def listed(where: Iterable[Any], texts: Iterable[str] = JOINTS) -> str:
    """Return the joints for which a condition holds, or their texts."""
    return ', '.join(compress(texts, where))


def render(template: str, **context: Any) -> str:
    """Return a page as a single file, from a template of this folder; text is escaped."""
    environment = Environment(loader=PackageLoader(__package__, ''), autoescape=True,
                              undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters.update(number=number, duration=duration, data_uri=_data_uri)
    return environment.get_template(template).render(context, version=__version__)


def _data_uri(picture: Picture) -> str:
    """Return an address that contains the figure; as separate images, their ids cannot clash."""
    return 'data:image/svg+xml;base64,' + base64.b64encode(picture.svg).decode('ascii')

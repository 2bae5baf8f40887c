"""Templates and number formats shared by the reports."""

import base64
import math
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from .drawing import Picture

NO_VALUE = '–'


def render(template: str, **context: Any) -> bytes:
    """
    Return a page, all of it in one file: no style, script or figure is fetched from anywhere.

    Parameters
    ----------
    template : str
        File name of a template of this folder.
    context
        What the template names. Text is escaped, wherever it comes from.

    """
    environment = Environment(loader=PackageLoader(__package__, ''), autoescape=True,
                              undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters.update(number=number, part=part, duration=duration, data_uri=data_uri)
    return encoded(environment.get_template(template).render(context))


def encoded(text: str) -> bytes:
    """Return text as UTF-8; file names may hold what is no text at all."""
    return text.encode('utf-8', 'replace')


def number(value: float, digits: int = 3) -> str:
    """Return a number with so many decimals, or a dash where it is none."""
    if not math.isfinite(value):
        return NO_VALUE
    if value == 0.0:
        return '0'
    text = f'{value:.{digits}f}'
    return text.lstrip('-') if float(text) == 0.0 else text.replace('-', '−')


def decimals(uncertainty: float) -> int:
    """Return how many decimals of a number mean something: two digits of its uncertainty."""
    if not 0.0 < uncertainty < math.inf:
        return 4
    return min(max(1 - math.floor(math.log10(uncertainty)), 0), 6)


def plus_minus(value: float, uncertainty: float) -> str:
    """Return a number with its uncertainty."""
    digits = decimals(uncertainty)
    return f'{number(value, digits)}\u00a0±\u00a0{number(uncertainty, digits)}'


def change(before: float, after: float) -> str:
    """Return by how much a number became greater or less: in percent, or how many times."""
    if not (before > 0.0 and math.isfinite(after)):
        return NO_VALUE
    if after > 10.0 * before:
        return f'×\u00a0{after / before:.0f}'
    percent = f'{100.0 * (after / before - 1.0):+.0f}'
    return ('0' if float(percent) == 0.0 else percent.replace('-', '−')) + '\u00a0%'


def duration(seconds: float) -> str:
    """Return a duration as people say it."""
    if seconds < 120.0:
        return f'{seconds:.1f} s'
    return f'{round(seconds) // 60} min {round(seconds) % 60} s'


def part(value: float, whole: float) -> str:
    """Return the length of a bar, in percent of the whole."""
    if not (math.isfinite(value) and whole > 0.0):
        return '0'
    return f'{100.0 * min(abs(value) / whole, 1.0):.0f}'


def data_uri(picture: Picture) -> str:
    """Return a figure as an address that holds it; as an image of its own, no ids can clash."""
    return 'data:image/svg+xml;base64,' + base64.b64encode(picture.svg).decode('ascii')

"""Rendering of the templates in this folder."""

import base64
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from .drawing import Picture
from .number_text import duration, number
from .. import __version__


def render(template: str, **context: Any) -> str:
    """
    Return a page in a single file, which fetches no style, script or figure.

    Parameters
    ----------
    template : str
        File name of a template of this folder.
    **context
        Variables of the template. Text is escaped.

    """
    environment = Environment(loader=PackageLoader(__package__, ''), autoescape=True,
                              undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.filters.update(number=number, duration=duration, data_uri=_data_uri)
    return environment.get_template(template).render(context, version=__version__)


def _data_uri(picture: Picture) -> str:
    """Return an address that contains the figure; as separate images, their ids cannot clash."""
    return 'data:image/svg+xml;base64,' + base64.b64encode(picture.svg).decode('ascii')

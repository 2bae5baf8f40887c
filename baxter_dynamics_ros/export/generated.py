"""The generated Python functions as statements, for exports to other languages."""

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path
import re
from textwrap import wrap
from typing import NamedTuple

from ..model import _closed_form

PATH = Path(_closed_form.__file__)


class Body(NamedTuple):
    """The body of a generated function, after its inputs have names; expressions are text."""

    statements: list[tuple[str, str]]  # name, value; names are reused
    results: list[str]  # row by row, one after the other


@cache
def bodies() -> dict[str, Body]:
    """Return the bodies of the generated functions by name."""
    result = {}
    for function in ast.parse(PATH.read_text(encoding='utf-8')).body:
        if isinstance(function, ast.FunctionDef):
            statements = [(statement.targets[0].id, ast.unparse(statement.value))
                          for statement in function.body if isinstance(statement, ast.Assign)
                          and isinstance(statement.targets[0], ast.Name)]
            returned = ast.unparse(function.body[-1]).removeprefix('return ')
            result[function.name] = Body(statements, returned.strip('()').split(', '))
    return result


def names(expressions: Iterable[str]) -> set[str]:
    """Return the names that expressions read."""
    return set(re.findall(r'[a-z]\w*', ' '.join(expressions)))


def folded(text: str, width: int, after: str = '    ', end: str = '') -> str:
    """Return text in lines: all but the first begin with ``after``, all but the last take end."""
    lines = wrap(text, width - len(end), subsequent_indent=after, break_long_words=False,
                 break_on_hyphens=False)
    return f'{end}\n'.join(lines)

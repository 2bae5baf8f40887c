"""The generated Python functions as statements, for exports to other languages."""

import ast
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from textwrap import wrap
from typing import NamedTuple

from ..model import _closed_form

PATH = Path(_closed_form.__file__)


class Body(NamedTuple):
    """The body of a generated function, after its inputs have names."""

    statements: list[tuple[str, ast.expr]]  # name, value; names are reused
    results: list[ast.expr]  # row by row, one after the other


@cache
def bodies() -> dict[str, Body]:
    """Return the bodies of the generated functions by name."""
    result = {}
    for function in ast.parse(PATH.read_text(encoding='utf-8')).body:
        if isinstance(function, ast.FunctionDef):
            statements, results = [], []
            for statement in function.body:
                target = statement.targets[0] if isinstance(statement, ast.Assign) else None
                if isinstance(statement, ast.Assign) and isinstance(target, ast.Name):
                    statements.append((target.id, statement.value))
                elif isinstance(statement, ast.Return) and isinstance(statement.value, ast.Tuple):
                    results = statement.value.elts
            result[function.name] = Body(statements, results)
    return result


def names(expressions: Iterable[ast.expr]) -> set[str]:
    """Return the names that expressions read."""
    return {node.id for expression in expressions for node in ast.walk(expression)
            if isinstance(node, ast.Name)}


def folded(text: str, width: int, after: str = '    ', end: str = '') -> str:
    """Return text in lines: all but the first begin with ``after``, all but the last take end."""
    lines = wrap(text, width - len(end), subsequent_indent=after, break_long_words=False,
                 break_on_hyphens=False)
    return f'{end}\n'.join(lines)

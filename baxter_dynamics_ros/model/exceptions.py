"""Exceptions raised by this package, and text in messages."""

from collections.abc import Sequence


class BaxterDynamicsError(Exception):
    """Base class of all exceptions raised by this package."""


class ArgumentError(BaxterDynamicsError, ValueError):
    """
    An argument is invalid.

    Attributes
    ----------
    argument : str
        Name of the argument.
    problem : str
        Reason why it is invalid.

    """

    def __init__(self, argument: str, problem: str) -> None:
        super().__init__(f'{argument}: {problem}')
        self.argument = argument
        self.problem = problem


def printable(text: object) -> str:
    """Return a text as one line, with unprintable characters as Python escapes."""
    return ''.join(character if character.isprintable() else ascii(character)[1:-1]
                   for character in str(text))


def first_names(names: Sequence[str], most: int = 8) -> str:
    """Return the first names, escaped by :func:`printable`, and the number of the others."""
    more = f' and {len(names) - most} more' if len(names) > most else ''
    return printable(', '.join(names[:most])) + more

"""Text output of all commands; text from outside is never interpreted by the terminal."""

import io
import os
import signal
import sys

from ..model.exceptions import BaxterDynamicsError


def printable(text: object) -> str:
    """Return a text as one line, with unprintable characters as Python escapes."""
    return ''.join(character if character.isprintable() else
                   character.encode('unicode_escape').decode() for character in str(text))


def say(*lines: object) -> None:
    """Print lines to stdout; see :func:`printable` and :func:`write`."""
    write('\n'.join(map(printable, lines)) + '\n')


def complain(line: str) -> None:
    """Print a line to stderr; see :func:`printable`."""
    print(printable(line), file=sys.stderr)


def write(text: str) -> None:
    """
    Write a text to stdout as it is; characters that the encoding lacks are escaped.

    Raises
    ------
    BaxterDynamicsError
        If stdout cannot be written.
    SystemExit
        If the reader of a pipe has ended.

    """
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

"""A function's body, as languages with infix notation and names share it."""

from collections.abc import Sequence
from textwrap import wrap
from typing import NamedTuple

from .functions import Function
from ..closed_form.quantities import CONSTANTS
from ..closed_form.source import assignments
from ..model.joints import N_JOINTS

# Vector of a program -> how its elements' names begin; they are numbered from 1.
PREFIXES = {'sin_q': 's', 'cos_q': 'c', 'qd': 'qd', 'qdd': 'qdd', 'tau': 'tau'}
NAMES = {f'{vector}[{i}]': f'{prefix}{i + 1}' for vector, prefix in PREFIXES.items()
         for i in range(N_JOINTS)}


class Body(NamedTuple):
    """What a function reads, and its statements."""

    elements: list[str]  # names of the vectors' elements that it reads, s1 and so on
    constants: list[str]  # names of the arm's numbers that it reads
    statements: list[tuple[str, str]]  # of (target, expression)


def body_of(function: Function, targets: Sequence[str], reuse: bool = False) -> Body:
    """
    Return the body of a function.

    Parameters
    ----------
    function : Function
        What to write.
    targets : sequence of str
        What to assign each output to.
    reuse : bool, optional
        Whether temporaries' names are taken again, so that arrays are freed early.

    """
    program = function.program
    read = {program.nodes[n][1] for n in program.used() if program.nodes[n][0] == 'input'}
    return Body([short for name, short in NAMES.items() if name in read],
                [name for name in CONSTANTS if name in read],
                assignments(program, targets, NAMES, reuse=reuse))


def folded(text: str, width: int, after: str = '    ', end: str = '') -> str:
    """Return text in lines: all but the first begin with ``after``, all but the last take end."""
    lines = wrap(text, width - len(end), subsequent_indent=after, break_long_words=False,
                 break_on_hyphens=False)
    return f'{end}\n'.join(lines)

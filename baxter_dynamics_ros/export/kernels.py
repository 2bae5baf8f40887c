"""Arithmetic of functions in Python: of floats, of NumPy arrays, or compiled by numba."""

from collections.abc import Iterable
from keyword import iskeyword
from math import prod

from .body import body_of
from .functions import Function
from .legend import parameters
from .python_parts import indented, long
from ..model.arm import BaxterArm
from ..model.exceptions import ArgumentError
from ..model.joints import N_JOINTS

_PREFIXES = {'sin_q': 's', 'cos_q': 'c'}
_LONGEST = 84
_IN_A_LINE = 6  # elements


def kernel(function: Function, arm: BaxterArm) -> str:
    """
    Return a function that computes one state, or arrays of as many states.

    It takes sin_q, cos_q and the other vectors as sequences of 7, the arm's numbers p as a
    sequence in the order of PARAMETERS, and sequences for its outputs, row by row.
    """
    outputs = function.quantity.outputs
    targets = [f'{output.symbol}[{i}]' for output in outputs for i in range(prod(output.shape))]
    body = body_of(function, targets, reuse=True)
    vectors = ('sin_q', 'cos_q', *function.quantity.inputs)
    lines = []
    for vector in vectors:
        prefix = _PREFIXES.get(vector, vector)
        lines += _taken((f'{prefix}{i + 1}', f'{vector}[{i}]') for i in range(N_JOINTS)
                        if f'{prefix}{i + 1}' in body.elements)
    lines += _taken((parameter.name, f'p[{i}]') for i, parameter in enumerate(parameters(arm))
                    if parameter.name in body.constants)
    for target, expression in body.statements:
        if len(target) + len(expression) > _LONGEST:
            expression = f'({expression})'
        lines += long(f'{target} = {expression}')
    arguments = ', '.join((*vectors, 'p', *(output.symbol for output in outputs)))
    return f'def _{function.quantity.name}({arguments}):\n' + indented(lines)


def check_module(name: str) -> None:
    """
    Refuse what cannot be the name of a module.

    Raises
    ------
    ArgumentError
        If it is none.

    """
    if not (name.isidentifier() and name.isascii()) or iskeyword(name):
        raise ArgumentError('name', f'{name!r} cannot be the name of a Python module; use a '
                            'letter, then letters, digits and _')


def _taken(pairs: Iterable[tuple[str, str]]) -> list[str]:
    """Return lines that assign a few elements each: name, where from."""
    pairs = list(pairs)
    groups = (zip(*pairs[i:i + _IN_A_LINE]) for i in range(0, len(pairs), _IN_A_LINE))
    return [' = '.join(', '.join(side) for side in group) for group in groups]

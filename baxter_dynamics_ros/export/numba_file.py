"""Python compiled by numba: one module, for one state and for many."""

from math import prod

from .body import folded
from .functions import COMMAND, Function
from .kernels import check_module, kernel
from .legend import storage
from .python_parts import (CHECK, function_docstring, indented, long, module_docstring,
                           parameter_table)
from .series import LARGEST, PER_TURN, steps, TURN
from ..model.arm import BaxterArm

_USAGE = """
Each function is there for one state, an array (7), and as ..._batch for n of them, an array
(n, 7), whose results have n as their first axis. Arrays are float64 and C-contiguous, as
np.ascontiguousarray(x, float) makes them, and so are results.
%s

The last argument is the array p of the arm's numbers; array() gives this arm's, and
array({**PARAMETERS, 'up_z': 1.62}) those on the moon:

    p = array()
    tau = inverse_dynamics(q, qd, qdd, p)

They may be called from other compiled functions, too. A function is compiled when it is first
called, which takes seconds, and kept on disk for the next process.
"""

_IMPORTS = """
from numba import njit
import numpy as np

BLOCK = 64  # states computed at a time
OPTIONS = {'cache': True, 'error_model': 'numpy'}

"""

_SINES = f'''

_NAMES = tuple(PARAMETERS)


def array(parameters=PARAMETERS):
    """Return an arm's numbers as an array in the order of PARAMETERS."""
    _check(parameters)
    return np.array([parameters[name] for name in PARAMETERS], float)


@njit(**OPTIONS)
def _sin_cos(angles, sines, cosines):
    """
    Write sin and cos to 1e-15 for angles below {LARGEST:g} rad, without a branch or a call.

    Taylor's series for half the angle, less whole turns, and the formulas of the double angle:
    the compiler takes several angles at a time.
    """
    for i in range(len(angles)):
        x = angles[i]
        turns = np.rint(x * {PER_TURN!r})
        y = 0.5 * (x - turns * {TURN[0]!r} - turns * {TURN[1]!r})
        z = y * y
%s
        s = y + y * z * s
        c = 1.0 + z * c
        sines[i] = 2.0 * s * c
        cosines[i] = (c - s) * (c + s)
'''


def files(functions: list[Function], arm: BaxterArm, name: str = 'baxter_dynamics',
          command: str = COMMAND) -> dict[str, str]:
    """
    Write functions in Python for numba.

    Parameters
    ----------
    functions : list of Function
        What to write.
    arm : BaxterArm
        Whose numbers are the defaults.
    name : str, optional
        How the module's name begins.
    command : str, optional
        What writes them, for the files' heads.

    Returns
    -------
    dict
        File name -> text: ``name_numba.py``.

    Raises
    ------
    ArgumentError
        If no module can have that name.

    """
    check_module(name)
    parts = [module_docstring('Dynamics of a Baxter arm, compiled by numba.', arm, command,
                              _usage(arm)),
             _IMPORTS, parameter_table(arm), '\n', CHECK, _SINES % _horner()]
    for function in functions:
        for text in (_one(function), _batch(function), kernel(function, arm)):
            parts += ['\n\n@njit(**OPTIONS)\n', text]
    return {f'{name}_numba.py': ''.join(parts)}


def _usage(arm: BaxterArm) -> str:
    stored = folded(storage(len(arm.base_parameters)), 98, '')
    return _USAGE % stored


def _horner() -> str:
    lines: list[str] = []
    for sine, cosine, n, m in steps():
        for name, value, order in (('s', sine, n), ('c', cosine, m)):
            start = f'{name} = {name} * z +' if lines[1:] else f'{name} ='
            lines.append(f'        {start} {value!r}  # 1 / {order}!'.replace('+ -', '- '))
    return '\n'.join(lines)


def _one(function: Function) -> str:
    name, outputs = function.quantity.name, function.quantity.outputs
    lines = function_docstring(function, '')
    lines += _check(function, '7,', 'arrays (7)')
    lines += ['s, c = np.empty(7), np.empty(7)', '_sin_cos(q, s, c)']
    lines += [f'{output.symbol} = np.empty({prod(output.shape)})' for output in outputs]
    given = ', '.join(('s', 'c', *function.quantity.inputs, 'p', *(o.symbol for o in outputs)))
    lines += long(f'_{name}({given})')
    lines += long('return ' + ', '.join(f'{o.symbol}.reshape({o.shape})' for o in outputs))
    return f'def {name}({", ".join(function.arguments)}, p):\n' + indented(lines)


def _batch(function: Function) -> str:
    name, outputs = function.quantity.name, function.quantity.outputs
    lines = ['"""', *long(f'Compute {name} of n states: {", ".join(function.arguments)} (n, 7); '
                          'results (n, ...).'), '"""',
             'n = len(q)', *_check(function, 'n, 7', 'arrays (n, 7)'),
             's, c = np.empty((BLOCK, 7)), np.empty((BLOCK, 7))']
    lines += [f'{output.symbol} = np.empty((n, {prod(output.shape)}))' for output in outputs]
    given = ', '.join(('s[j]', 'c[j]', *(f'{a}[i]' for a in function.quantity.inputs), 'p',
                       *(f'{output.symbol}[i]' for output in outputs)))
    lines += ['for start in range(0, n, BLOCK):',
              '    m = min(BLOCK, n - start)',
              '    _sin_cos(q[start:start + m].reshape(-1), s[:m].reshape(-1), '
              'c[:m].reshape(-1))',
              '    for j in range(m):',
              '        i = start + j',
              *('        ' + line for line in long(f'_{name}({given})'))]
    lines += long('return ' + ', '.join(
        f'{o.symbol}.reshape({("n", *o.shape)})'.replace("'n'", 'n') for o in outputs))
    return f'def {name}_batch({", ".join(function.arguments)}, p):\n' + indented(lines)


def _check(function: Function, shape: str, text: str) -> list[str]:
    """Return a check of the arguments' shapes: compiled code reads beyond them, or what is not."""
    wrong = ' or '.join((*(f'{argument}.shape != ({shape})' for argument in function.arguments),
                         'len(p) != len(_NAMES)'))
    return [f'if {wrong}:', f"    raise ValueError('expected {text}, and p by array()')"]

"""Exports as C99 and as a Python module: the generated files with the parameters of an arm."""

from textwrap import fill, wrap

from .common import FRAMES, head, parameters, PATH
from ..model.arm import BaxterArm

_C_USAGE = (
    'Compile with optimisation for your processor:',
    '    gcc -O3 -march=native -c baxter_dynamics.c',
    'The source needs C99 and the C library alone, and allocates nothing. Do not add -ffast-math: '
    'batches are vectorised without it.')
_STATE = {'q': (0.1, -0.5, 0.2, 1.0, -0.3, 0.7, 0.4),
          'qd': (0.5, -0.4, 0.3, 0.6, -0.8, 1.0, -1.2),
          'qdd': (1.0, 0.5, -1.0, 2.0, -1.5, 1.0, 3.0)}
_EXAMPLE = """#include <stdio.h>

#include "baxter_dynamics.h"

int main(void)
{
%s
    double tau[7];

    baxter_dynamics_inverse_dynamics(q, qd, qdd, &baxter_dynamics_default, tau);
    for (int i = 0; i < 7; i++)
        printf("%%.6f ", tau[i]);
    printf("\\n");
    return 0;
}
"""
_PYTHON_USAGE = """
Each function takes sin q, cos q and further vectors as sequences of 7 scalars, and the parameters
in the order of PARAMETERS, such as VALUES. It returns a tuple of scalars: its results row by row,
one after the other, as FUNCTIONS describes them. Scalars may be floats, NumPy arrays, CasADi or
SymPy symbols, JAX arrays or PyTorch tensors:

    tau = inverse_dynamics(jnp.sin(q), jnp.cos(q), qd, qdd, VALUES)

For NumPy arrays (..., 7) of states, evaluate returns arrays of the shapes in FUNCTIONS:

    tau = evaluate(inverse_dynamics, q, qd, qdd)
"""
_EVALUATE = '''

def evaluate(function, q, *vectors, parameters=VALUES):
    """
    Return the results of a function for NumPy arrays of states (..., 7).

    vectors are those that FUNCTIONS names: qd, qdd or tau. An array, or a tuple of arrays.
    """
    import math

    import numpy as np
    q, *vectors = np.broadcast_arrays(q, *vectors)
    if q.shape[-1:] != (7,):
        raise ValueError(f'expected arrays of shape (..., 7), got {q.shape}')
    inputs = [np.moveaxis(x, -1, 0) for x in (np.sin(q), np.cos(q), *vectors)]
    values = function(*inputs, parameters)
    results, start = [], 0
    for _, shape, _, _ in FUNCTIONS[function.__name__][1]:
        result = np.empty((*q.shape[:-1], math.prod(shape)))
        for i in range(result.shape[-1]):
            result[..., i] = values[start + i]
        start += result.shape[-1]
        results.append(result.reshape(*q.shape[:-1], *shape))
    return results[0] if len(results) == 1 else tuple(results)
'''


def c_files(arm: BaxterArm, command: str) -> dict[str, str]:
    """Return the exported files: name -> text."""
    about = head(arm, command)
    header, source = (PATH.with_suffix(ending).read_text(encoding='utf-8').split('\n', 1)[1]
                      for ending in ('.h', '.c'))  # without the line about the generator
    source = source.replace('_closed_form.h', 'baxter_dynamics.h')
    values = ''.join(f'    .{p.name} = {p.value!r},\n' for p in parameters(arm))
    marker = '\n\n/* M (7, 7)'
    default = f'\n\nconst baxter_dynamics_parameters baxter_dynamics_default = {{\n{values}}};'
    tau = arm.inverse_dynamics(*_STATE.values())
    states = '\n'.join(f'    const double {name}[7] = {{{", ".join(map(repr, state))}}};'
                       for name, state in _STATE.items())
    example = _comment(
        about[0], 'tau [N m] of one state:',
        '    gcc -O3 example.c baxter_dynamics.c -o example -lm && ./example', 'prints',
        '    ' + ' '.join(f'{x:.6f}' for x in tau))
    return {'baxter_dynamics.h': _comment(*about, FRAMES, *_C_USAGE) + header,
            'baxter_dynamics.c': _comment(*about) + source.replace(marker, default + marker, 1),
            'example.c': example + _EXAMPLE % states}


def _comment(*paragraphs: str) -> str:
    lines = [f' * {line}' for paragraph in paragraphs for line in
             ([paragraph] if paragraph.startswith(' ') else wrap(paragraph, 95))]
    return '\n'.join(['/*', *lines, ' */\n'])


def python_files(arm: BaxterArm, command: str) -> dict[str, str]:
    """Return the exported file: its name -> its text."""
    text = PATH.read_text(encoding='utf-8')
    tables, functions = text[text.index('PARAMETERS = '):].split('\n\n\ndef ', 1)
    about = '\n\n'.join(fill(paragraph, 99) for paragraph in (*head(arm, command), FRAMES))
    values = ''.join(f'    {p.value!r},  # {p.name} [{p.unit}]: {p.text}\n'
                     for p in parameters(arm))
    return {'baxter_dynamics.py': ''.join([
        f'# flake8: noqa\n"""\nDynamics of a Baxter arm.\n\n{about}\n{_PYTHON_USAGE}"""\n\n',
        tables, f'\n# The exported arm.\nVALUES = (\n{values})\n\n\ndef ', functions, _EVALUATE])}

"""Exports as C99, Python and MATLAB: the generated functions with the parameters of an arm."""

import ast
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import chain
from math import prod
from pathlib import Path
import re
from textwrap import fill, wrap

import numpy as np

from .parameter_table import FRAMES, parameters
from ..model import _closed_form, BaxterArm, JOINTS
from ..model._closed_form import FUNCTIONS, PARAMETERS

_PATH = Path(_closed_form.__file__)
# Begins the head of every exported file.
MARK = 'Written by baxter_dynamics export'
LABELS = {'q': 'joint positions [rad]', 'qd': 'joint velocities [rad/s]',
          'qdd': 'joint accelerations [rad/s^2]', 'tau': 'joint torques [N m]'}
_C_USAGE = (
    'Compile with optimisation for your processor:',
    '    gcc -O3 -march=native -c baxter_dynamics.c',
    'The source needs C99 and the C library alone, and allocates nothing. Do not add -ffast-math: '
    'batches are vectorised without it.')
_STATE = {'q': (0.1, -0.5, 0.2, 1.0, -0.3, 0.7, 0.4),
          'qd': (0.5, -0.4, 0.3, 0.6, -0.8, 1.0, -1.2),
          'qdd': (1.0, 0.5, -1.0, 2.0, -1.5, 1.0, 3.0)}
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
_WIDTH = 92  # of a line of MATLAB
# Prefix of the elements' names in the generated functions -> where MATLAB takes them from.
_VECTORS = {'s': 'sin_q', 'c': 'cos_q', 'v': 'qd', 'u': 'qdd', 'f': 'tau'}


def head(arm: BaxterArm, command: str) -> list[str]:
    """Return the paragraphs that open a file, written by a command."""
    payload = arm.payload
    carried = (f'The parameters include a payload of {payload.mass:g} kg at '
               f'{list(payload.center_of_mass)} m in the hand frame.' if payload.mass
               else 'The hand is empty.')
    gravity = ', '.join(f'{x + 0.0:.6g}' for x in arm.gravity_vector)
    return [
        f'{MARK}: `{command}`.',
        'Closed-form rigid-body dynamics of a Baxter arm, tau = M(q) qdd + C(q, qd) qd + G(q), '
        'after "Lagrange-Euler Closed Dynamics Model of the Baxter Robot" with two errors of the '
        'printed model corrected.',
        f'Joint order: {", ".join(JOINTS)}. tau is positive in the direction of positive q. The '
        'effort that a real Baxter measures also includes the springs at s1, friction and bias.',
        f'{carried} The gravity vector is ({gravity}) m/s^2 in the base frame.']


def c_files(arm: BaxterArm, command: str) -> dict[str, str]:
    """Return the exported files: name -> text."""
    about = head(arm, command)
    header, source = (_PATH.with_suffix(ending).read_text(encoding='utf-8').split('\n', 1)[1]
                      for ending in ('.h', '.c'))  # without the line about the generator
    source = source.replace('_closed_form.h', 'baxter_dynamics.h')
    values = ''.join(f'    .{p.name} = {p.value!r},\n' for p in parameters(arm))
    marker = '\n\n/* M (7, 7)'
    default = f'\n\nconst baxter_dynamics_parameters baxter_dynamics_default = {{\n{values}}};'
    tau = arm.inverse_dynamics(*_STATE.values())
    states = '\n    '.join(f'const double {name}[7] = {{{", ".join(map(repr, state))}}};'
                           for name, state in _STATE.items())
    example = Path(__file__).with_name('example.c').read_text(encoding='utf-8')
    example_head = _comment(
        about[0], 'tau [N m] of one state:',
        '    gcc -O3 example.c baxter_dynamics.c -o example -lm && ./example', 'prints',
        '    ' + ' '.join(f'{x:.6f}' for x in tau))
    return {'baxter_dynamics.h': _comment(*about, FRAMES, *_C_USAGE) + header,
            'baxter_dynamics.c': _comment(*about) + source.replace(marker, default + marker, 1),
            'example.c': example_head + example.replace('<states>', states)}


def _comment(*paragraphs: str) -> str:
    lines = [f' * {line}' for paragraph in paragraphs for line in
             ([paragraph] if paragraph.startswith(' ') else wrap(paragraph, 95))]
    return '\n'.join(['/*', *lines, ' */\n'])


def python_files(arm: BaxterArm, command: str) -> dict[str, str]:
    """Return the exported file: its name -> its text."""
    text = _PATH.read_text(encoding='utf-8')
    tables, functions = text[text.index('PARAMETERS = '):].split('\n\n\ndef ', 1)
    about = '\n\n'.join(fill(paragraph, 99) for paragraph in (*head(arm, command), FRAMES))
    values = ''.join(f'    {p.value!r},  # {p.name} [{p.unit}]: {p.text}\n'
                     for p in parameters(arm))
    return {'baxter_dynamics.py': ''.join([
        f'# flake8: noqa\n"""\nDynamics of a Baxter arm.\n\n{about}\n{_PYTHON_USAGE}"""\n\n',
        tables, f'\n# The exported arm.\nVALUES = (\n{values})\n\n\ndef ', functions, _EVALUATE])}


@cache
def bodies() -> dict[str, tuple[list[tuple[str, str]], list[str]]]:
    """
    Return statements and results of each generated function, after its inputs have names.

    A statement is a name, which may be reused, and its value; results are row by row, one after
    the other. Values are text.
    """
    result = {}
    for function in ast.parse(_PATH.read_text(encoding='utf-8')).body:
        if isinstance(function, ast.FunctionDef):
            statements = [(statement.targets[0].id, ast.unparse(statement.value))
                          for statement in function.body if isinstance(statement, ast.Assign)
                          and isinstance(statement.targets[0], ast.Name)]
            returned = ast.unparse(function.body[-1]).removeprefix('return ')
            result[function.name] = statements, returned.strip('()').split(', ')
    return result


def names(expressions: Iterable[str]) -> set[str]:
    """Return the names that expressions read."""
    return set(re.findall(r'[a-z]\w*', ' '.join(expressions)))


def matlab_files(arm: BaxterArm, command: str) -> dict[str, str]:
    """Return the exported files: path -> text."""
    about = head(arm, command)
    result = {f'+baxter_dynamics/{name}.m': _matlab_function(name, about) for name in FUNCTIONS}
    result['+baxter_dynamics/parameters.m'] = _matlab_parameters(arm, about)
    return result


def _matlab_parameters(arm: BaxterArm, about: list[str]) -> str:
    lines = ['function p = parameters()', *_help(
        'PARAMETERS  Parameters of the exported arm, a struct.', '',
        'Change a field and pass the struct as the last argument of a function for another arm.',
        *about, FRAMES)]
    for parameter in parameters(arm):
        value = f'    p.{parameter.name} = {parameter.value!r};'
        lines.append(f'{value:<38}% {parameter.unit}, {parameter.text}')
    return '\n'.join([*lines, 'end', ''])


def _matlab_function(name: str, about: list[str]) -> str:
    vectors, outputs = ('q', *FUNCTIONS[name][0]), FUNCTIONS[name][1]
    results = ', '.join(output[0] for output in outputs)
    call = f'[{results}] = {name}({", ".join(vectors)}, p)'
    sizes = ', '.join(f'size({vector})' for vector in vectors)
    lines = [f'function {call}', *_help(
        f'{name.upper()}  {"; ".join(output[3] for output in outputs)}.', '',
        f'{call.replace("] = ", "] = baxter_dynamics.")}', '',
        *(f'{vector} (7, n) {LABELS[vector]}; each column is a state' for vector in vectors),
        'p struct of parameters; by default baxter_dynamics.parameters()',
        *(f'{symbol} ({", ".join(map(str, shape))}, n) [{unit}] {text}'
          for symbol, shape, unit, text in outputs), '', *about),
        f'    if nargin < {len(vectors) + 1}', '        p = baxter_dynamics.parameters();',
        '    end', '    n = size(q, 2);', f'    if ~isequal({sizes}, [7, n])',
        f"        error('baxter_dynamics:size', '{', '.join(vectors)}: expected 7 x n');",
        '    end', '    sin_q = sin(q);', '    cos_q = cos(q);', *_body(name)]
    for (symbol, shape, _, _), rows in zip(outputs, _rows(outputs)):
        place = f'out({min(rows) + 1}:{max(rows) + 1}, :)'
        lines.append(f'    {symbol} = reshape({place}, {", ".join(map(str, shape))}, n);'
                     if len(shape) > 1 else f'    {symbol} = {place};')
    return '\n'.join([*lines, 'end', ''])


def _body(name: str) -> Iterator[str]:
    statements, results = bodies()[name]
    read = names([*(value for _, value in statements), *results])
    yield from (f'    {x} = {_VECTORS[x[0]]}({x[1:]}, :);' for x in
                (f'{prefix}{i}' for prefix in _VECTORS for i in range(1, 8)) if x in read)
    yield from (f'    {x} = p.{x};' for x in PARAMETERS if x in read)
    for target, value in statements:
        yield _statement(target, value)
    yield f'    out = zeros({len(results)}, n);'
    for row, value in zip(chain(*_rows(FUNCTIONS[name][1])), results):
        yield _statement(f'out({row + 1}, :)', value)


def _rows(outputs: Iterable[tuple[str, tuple[int, ...], str, str]]) -> Iterator[list[int]]:
    """Yield the rows of each result's elements: MATLAB stores arrays column by column."""
    start = 0
    for _, shape, _, _ in outputs:
        rows = start + np.arange(prod(shape)).reshape(shape, order='F')
        yield rows.ravel().tolist()
        start += prod(shape)


def _statement(target: str, value: str) -> str:
    text = f'    {target} = {value};'.replace(' * ', ' .* ').replace(' / ', ' ./ ')
    return ' ...\n'.join(wrap(text, _WIDTH - 4, subsequent_indent=' ' * 8))


def _help(title: str, *paragraphs: str) -> list[str]:
    """Return comment lines, which `help` shows."""
    lines = [f'%{title}']
    for paragraph in paragraphs:
        lines += [f'%   {line}'.rstrip() for line in wrap(
            paragraph, _WIDTH, subsequent_indent='  ', break_on_hyphens=False) or ['']]
    return lines

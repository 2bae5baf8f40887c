"""Export as a package of functions for MATLAB and GNU Octave."""

from collections.abc import Iterator
from math import prod
from textwrap import wrap

import numpy as np

from .common import bodies, FRAMES, head, LABELS, names, parameters
from ..model._closed_form import FUNCTIONS, PARAMETERS
from ..model.arm import BaxterArm

_WIDTH = 92
# Prefix of the elements' names in the generated functions -> where they come from.
_VECTORS = {'s': 'sin_q', 'c': 'cos_q', 'v': 'qd', 'u': 'qdd', 'f': 'tau'}


def files(arm: BaxterArm, command: str) -> dict[str, str]:
    """Return the exported files: path -> text."""
    about = head(arm, command)
    result = {f'+baxter_dynamics/{name}.m': _function(name, about) for name in FUNCTIONS}
    result['+baxter_dynamics/parameters.m'] = _parameters(arm, about)
    return result


def _parameters(arm: BaxterArm, about: list[str]) -> str:
    lines = ['function p = parameters()', *_help(
        'PARAMETERS  Parameters of the exported arm, a struct.', '',
        'Change a field and pass the struct as the last argument of a function for another arm.',
        *about, FRAMES)]
    for parameter in parameters(arm):
        value = f'    p.{parameter.name} = {parameter.value!r};'
        lines.append(f'{value:<38}% {parameter.unit}, {parameter.text}')
    return '\n'.join([*lines, 'end', ''])


def _function(name: str, about: list[str]) -> str:
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
    start = 0
    for symbol, shape, _, _ in outputs:
        rows = f'out({start + 1}:{start + prod(shape)}, :)'
        start += prod(shape)
        lines.append(f'    {symbol} = reshape({rows}, {", ".join(map(str, shape))}, n);'
                     if len(shape) > 1 else f'    {symbol} = {rows};')
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
    for row, value in zip(_rows(name), results):
        yield _statement(f'out({row + 1}, :)', value)


def _rows(name: str) -> Iterator[int]:
    """Yield the rows of the results: MATLAB stores arrays column by column."""
    start = 0
    for _, shape, _, _ in FUNCTIONS[name][1]:
        rows = start + np.arange(prod(shape)).reshape(shape, order='F')
        yield from rows.ravel().tolist()
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

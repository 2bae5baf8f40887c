"""C99 without allocation: a header, a source for one state and for many, and an example."""

from collections.abc import Iterable
from math import prod

import numpy as np

from .body import body_of, folded
from .c_support import support
from .functions import COMMAND, describe, Function
from .legend import FRAMES, head, parameters, storage
from .series import LARGEST
from ..model.arm import BaxterArm
from ..model.exceptions import ArgumentError
from ..model.joints import N_JOINTS

_WIDTH = 99
_FIXED = '\xa0'  # stands for a space at which no line breaks

_SPEED = (
    'Compile it with optimisation for your processor:',
    '    gcc -O3 -march=native -c {name}.c',
    'All quantities together take some seconds to compile. Beside C99 it needs nothing. There is '
    'no use in -ffast-math: a batch is computed in blocks, its sines and cosines in a loop of '
    'their own and by polynomials, all of which the compiler vectorises as it is. But -std=c99 '
    'keeps gcc from fusing products with sums: add -ffp-contract=fast to it.')
_ARRAYS = (
    'Each function is there for one state, and as ..._batch for n of them, one after the other: '
    'q[7 * i + k] is joint k of state i, and what belongs to state i begins at i times the size '
    'of one. Results must not overlap arguments. All functions may be called from many threads.')
_ANGLES = f'Angles: |q| < {LARGEST:g} rad; beyond, sines and cosines are wrong.'

# The state of the example.
_STATE = {'q': (0.1, -0.5, 0.2, 1.0, -0.3, 0.7, 0.4),
          'qd': (0.5, -0.4, 0.3, 0.6, -0.8, 1.0, -1.2),
          'qdd': (1.0, 0.5, -1.0, 2.0, -1.5, 1.0, 3.0),
          'tau': (2.0, -30.0, -3.0, -12.0, 0.5, -1.0, 0.1)}


def files(functions: list[Function], arm: BaxterArm, name: str = 'baxter_dynamics',
          command: str = COMMAND) -> dict[str, str]:
    """
    Write functions in C99.

    Parameters
    ----------
    functions : list of Function
        What to write.
    arm : BaxterArm
        Whose numbers are the defaults.
    name : str, optional
        How the names of files and symbols begin.
    command : str, optional
        What writes them, for the files' heads.

    Returns
    -------
    dict
        File name -> text: ``name.h``, ``name.c`` and ``example.c``.

    Raises
    ------
    ArgumentError
        If no name in C begins so.

    """
    if not (name.isidentifier() and name.isascii()):
        raise ArgumentError('name', f'{name!r} cannot begin a name in C; use a letter, then '
                            'letters, digits and _')
    return {f'{name}.h': _header(functions, arm, name, command),
            f'{name}.c': _source(functions, arm, name, command),
            'example.c': _example(functions, arm, name, command)}


def _header(functions: list[Function], arm: BaxterArm, name: str, command: str) -> str:
    guard = f'{name.upper()}_H'
    parts = [
        _comment(*head(arm, command), '', *(line.format(name=name) for line in _SPEED)),
        f'#ifndef {guard}\n#define {guard}\n\n#include <stddef.h>\n\n'
        '#ifdef __cplusplus\nextern "C" {\n#endif',
        '\n'.join((_comment("The arm's numbers.", FRAMES), f'typedef struct {name}_parameters {{',
                   *(f'    double {p.name}; /* {p.unit}, {p.text} */' for p in parameters(arm)),
                   f'}} {name}_parameters;')),
        '/* Those of the arm that this was exported for; copy them to change some. */\n'
        f'extern const {name}_parameters {name}_default;',
        _comment(_ARRAYS, storage(len(arm.base_parameters)), _ANGLES)]
    for function in functions:
        lines = [*(f'{a}: 7, {describe(a)}' for a in function.arguments),
                 *(f'{o.symbol}: {" x ".join(map(str, o.shape))}, {o.text} [{o.unit}]'
                   for o in function.quantity.outputs),
                 f'{function.program.operations()} operations a state, beside sines and cosines.']
        parts.append('\n'.join((_comment(*lines), _prototype(function, name) + ';',
                                _batch_prototype(function, name) + ';')))
    parts.append(f'#ifdef __cplusplus\n}}\n#endif\n\n#endif /* {guard} */')
    return '\n\n'.join(parts) + '\n'


def _source(functions: list[Function], arm: BaxterArm, name: str, command: str) -> str:
    values = ''.join(f'\n    .{p.name} = {p.value!r},' for p in parameters(arm))
    parts = [_comment(*head(arm, command), f'Usage: see {name}.h.'),
             f'#include "{name}.h"', support(),
             f'const {name}_parameters {name}_default = {{{values}\n}};']
    for function in functions:
        parts += [_kernel(function, name), _one(function, name), _batch(function, name)]
    return '\n\n'.join(parts) + '\n'


def _kernel(function: Function, name: str) -> str:
    """Return the arithmetic of one state, whose vectors' elements are a stride apart."""
    targets = [f'{output.symbol}[{i} * stride]' for output in function.quantity.outputs
               for i in range(prod(output.shape))]
    body = body_of(function, targets)
    vectors = {'sin_q': 's', 'cos_q': 'c', **{vector: vector for vector in
                                              function.quantity.inputs}}
    arguments = ('size_t stride', *(f'const double *restrict {vector}' for vector in vectors),
                 f'const {name}_parameters *restrict p',
                 *(f'double *restrict {output.symbol}' for output in function.quantity.outputs))
    lines = [_listed(f'INLINE void {function.quantity.name}(', arguments, ')'), '{']
    for vector, short in vectors.items():
        read = [f'{short}{i + 1} = {vector}[{i} * stride]' for i in range(N_JOINTS)
                if f'{short}{i + 1}' in body.elements]
        lines.append(_listed('    const double ', read, ';'))
    lines.append(_listed('    const double ', [f'{constant} = p->{constant}'
                                               for constant in body.constants], ';'))
    outputs = set(targets)
    for target, expression in body.statements:
        kind = '' if target in outputs else 'const double '
        lines.append(folded(f'    {kind}{target} = {expression};', _WIDTH, ' ' * 8))
    return '\n'.join([*lines, '}'])


def _one(function: Function, name: str) -> str:
    call = ', '.join(('1', 's', 'c', *function.quantity.inputs, 'p',
                      *(output.symbol for output in function.quantity.outputs)))
    return f"""{_prototype(function, name)}
{{
    double s[JOINTS], c[JOINTS];

    for (size_t i = 0; i < JOINTS; i++)
        sin_cos(q[i], &s[i], &c[i]);
    {function.quantity.name}({call});
}}"""


def _batch(function: Function, name: str) -> str:
    sizes = {output.symbol: prod(output.shape) for output in function.quantity.outputs}
    local = _listed('    double ', (
        *(f'{vector}[JOINTS * BLOCK]' for vector in ('s', 'c')),
        *(f'{a}_[JOINTS * BLOCK]' for a in function.arguments),
        *(f'{symbol}_[{size} * BLOCK]' for symbol, size in sizes.items())), ';')
    read = '\n'.join(f'        to_block(m, {a} + JOINTS * start, {a}_);'
                     for a in function.arguments)
    call = _listed(f'            {function.quantity.name}(', (
        'BLOCK', 's + j', 'c + j', *(f'{a}_ + j' for a in function.quantity.inputs), 'p',
        *(f'{symbol}_ + j' for symbol in sizes)), ');')
    written = '\n'.join(f'        from_block(m, {size}, {symbol}_, {symbol} + {size} * start);'
                        for symbol, size in sizes.items())
    return f"""{_batch_prototype(function, name)}
{{
{local}

    for (size_t start = 0; start < n; start += BLOCK) {{
        const size_t m = n - start < BLOCK ? n - start : BLOCK;
{read}
        for (size_t i = 0; i < JOINTS * BLOCK; i++)
            sin_cos(q_[i], &s[i], &c[i]);
        for (size_t j = 0; j < BLOCK; j++)
{call}
{written}
    }}
}}"""


def _prototype(function: Function, name: str) -> str:
    return _listed(f'void {name}_{function.quantity.name}(', (
        *(f'const double {a}[7]' for a in function.arguments), f'const {name}_parameters *p',
        *(f'double {o.symbol}[{prod(o.shape)}]' for o in function.quantity.outputs)), ')')


def _batch_prototype(function: Function, name: str) -> str:
    return _listed(f'void {name}_{function.quantity.name}_batch(', (
        'size_t n', *(f'const double *{a}' for a in function.arguments),
        f'const {name}_parameters *p',
        *(f'double *{o.symbol}' for o in function.quantity.outputs)), ')')


def _example(functions: list[Function], arm: BaxterArm, name: str, command: str) -> str:
    function = next((f for f in functions if f.quantity.name == 'inverse_dynamics'), functions[0])
    output, *others = function.quantity.outputs
    size, columns = prod(output.shape), output.shape[-1]
    value = getattr(arm, function.quantity.name)(*(_STATE[a] for a in function.arguments))
    value = np.reshape(value[0] if others else value, (-1, columns))
    printed = [' '.join(f'{x:.6f}' for x in row) for row in value.tolist()]
    call = ', '.join((*function.arguments, f'&{name}_default', output.symbol,
                      *(other.symbol for other in others)))
    states = '\n'.join(f'    const double {a}[7] = {{{", ".join(map(repr, _STATE[a]))}}}; '
                       f'/* {describe(a)} */' for a in function.arguments)
    arrays = ', '.join(f'{o.symbol}[{prod(o.shape)}]' for o in (output, *others))
    says = _comment(
        f'{output.symbol} of one state: {output.text} [{output.unit}].',
        f'    gcc -O3 -march=native example.c {name}.c -o example -lm && ./example',
        'prints', *(f'    {row}' for row in printed), head(arm, command)[0])
    return f"""{says}

#include <stdio.h>

#include "{name}.h"

int main(void)
{{
{states}
    double {arrays};

    {name}_{function.quantity.name}({call});
    for (int i = 0; i < {size}; i++)
        printf("%.6f%s", {output.symbol}[i], i % {columns} == {columns - 1} ? "\\n" : " ");
    return 0;
}}
"""


def _listed(start: str, elements: Iterable[str], end: str) -> str:
    """Return elements with commas, in lines that break behind commas alone."""
    text = start + ', '.join(elements) + end
    after = ' ' * (len(text) - len(text.lstrip()) + 4)
    kept = text.replace(' ', _FIXED).replace(f',{_FIXED}', ', ')
    return folded(kept, _WIDTH, after).replace(_FIXED, ' ')


def _comment(*paragraphs: str) -> str:
    lines = [line for paragraph in paragraphs
             for line in folded(paragraph, _WIDTH - 3, '').split('\n')]
    return '\n'.join(['/*', *(f' * {line}'.rstrip() for line in lines), ' */'])

"""MATLAB and GNU Octave: a function file for each quantity, and one for the arm's numbers."""

import re

import numpy as np

from .body import body_of, folded
from .functions import COMMAND, describe, Function
from .legend import FRAMES, head, parameters
from ..model.arm import BaxterArm
from ..model.exceptions import ArgumentError
from ..model.joints import N_JOINTS

_WIDTH = 92
_LONGEST_NAME = 63  # that MATLAB tells apart
# The end of the parameters' file: it checks and returns what it is given.
_FIELDS = """    if nargin
        unknown = setdiff(fieldnames(given), fieldnames(p));
        missing = setdiff(fieldnames(p), fieldnames(given));
        if ~isempty(unknown) || ~isempty(missing)
            error('%s:fields', 'p: unknown field [%%s], missing field [%%s]', ...
                strjoin(unknown(:)', ' '), strjoin(missing(:)', ' '));
        end
        p = given;
    end"""
_ELEMENTWISE = re.compile(r' ([*/]) ')


def files(functions: list[Function], arm: BaxterArm, name: str = 'baxter_dynamics',
          command: str = COMMAND) -> dict[str, str]:
    """
    Write functions for MATLAB and GNU Octave.

    Parameters
    ----------
    functions : list of Function
        What to write.
    arm : BaxterArm
        Whose numbers are the defaults.
    name : str, optional
        How the functions' names begin.
    command : str, optional
        What writes them, for the files' heads.

    Returns
    -------
    dict
        File name -> text: ``name_parameters.m``, and ``name_gravity.m`` and so on.

    Raises
    ------
    ArgumentError
        If MATLAB would refuse a function of that name.

    """
    names = [f'{name}_parameters', *(f'{name}_{f.quantity.name}' for f in functions)]
    if not re.fullmatch('[A-Za-z][A-Za-z0-9_]*', name) or len(max(names, key=len)) > _LONGEST_NAME:
        raise ArgumentError('name', f'{name!r} cannot begin the name of a MATLAB function; use a '
                            'letter, then letters, digits and _, and not too many')
    explained = head(arm, command)
    result = {f'{names[0]}.m': _parameters_file(arm, names[0], explained)}
    for own, function in zip(names[1:], functions):
        result[f'{own}.m'] = _function_file(function, own, names[0], explained)
    return result


def _parameters_file(arm: BaxterArm, name: str, explained: list[str]) -> str:
    lines = [f'function p = {name}(given)',
             *_help(f"{name.upper()}  The arm's numbers, for the functions beside this one.", '',
                    'Change a field to change the arm: hand p over as their last argument.',
                    'A struct with other fields than these is refused.', '',
                    *explained, FRAMES)]
    for parameter in parameters(arm):
        value = f'    p.{parameter.name} = {parameter.value!r};'
        lines.append(f'{value:<38}% {parameter.unit}, {parameter.text}')
    lines.append(_FIELDS % name)
    return _text(lines, 'end')


def _function_file(function: Function, name: str, defaults: str, explained: list[str]) -> str:
    body = body_of(function, _rows(function), reuse=True)
    outputs = function.quantity.outputs
    symbols = ', '.join(output.symbol for output in outputs)
    call = f'[{symbols}]' if len(outputs) > 1 else symbols
    call = f'{call} = {name}({", ".join(function.arguments)}, p)'
    lines = [f'function {call}', *_help(
        f'{name.upper()}  {outputs[0].text if len(outputs) == 1 else symbols}.', '',
        f'{call.replace(", p)", ")")}',
        call, '',
        *(f'{argument:<4} (7, n) {describe(argument)}; each column is a state'
          for argument in function.arguments),
        f"p    struct, the arm's numbers; without it, those of {defaults}", '',
        *(f'{output.symbol} {_shape(output.shape)} [{output.unit}] {output.text}'
          for output in outputs), '',
        f'{function.program.operations()} operations a state, beside sines and cosines.', '',
        *explained)]
    count = len(function.arguments)
    lines += [f'    narginchk({count}, {count + 1});', f'    if nargin <= {count}',
              f'        p = {defaults}();', '    else', f'        p = {defaults}(p);', '    end',
              '    n = size(q, 2);', *_check(function.arguments, name)]
    lines.append('    s = sin(q);    c = cos(q);')
    lines += _in_rows(5, [f'{element} = {element.rstrip("1234567")}({element[-1]}, :);'
                          for element in body.elements])
    lines += _in_rows(5, [f'{constant} = p.{constant};' for constant in body.constants])
    lines.append(f'    out = zeros({function.size}, n);')
    lines += [_statement(*statement) for statement in body.statements]
    start = 0
    for output in outputs:
        size = int(np.prod(output.shape))
        rows = f'out({start + 1}:{start + size}, :)'
        shape = ', '.join(str(length) for length in output.shape)
        lines.append(f'    {output.symbol} = ' + (
            f'reshape({rows}, {shape}, n);' if len(output.shape) > 1 else f'{rows};'))
        start += size
    return _text(lines, 'end')


def _rows(function: Function) -> list[str]:
    """Return what to assign the outputs to: arrays are stored column by column."""
    result, start = [], 0
    for output in function.quantity.outputs:
        for index in np.ndindex(*output.shape):
            row = int(np.ravel_multi_index(index, output.shape, order='F'))
            result.append(f'out({start + row + 1}, :)')
        start += int(np.prod(output.shape))
    return result


def _check(arguments: tuple[str, ...], name: str) -> list[str]:
    sizes = ', '.join(f'size({argument})' for argument in arguments)
    return [f'    if ~isequal({sizes}, [{N_JOINTS}, n])',
            f"        error('{name}:size', '{', '.join(arguments)}: expected {N_JOINTS} x n');",
            '    end']


def _in_rows(count: int, statements: list[str]) -> list[str]:
    return ['    ' + '  '.join(statements[i:i + count])
            for i in range(0, len(statements), count)]


def _statement(target: str, expression: str) -> str:
    expression = _ELEMENTWISE.sub(r' .\1 ', expression)
    return folded(f'    {target} = {expression};', _WIDTH, ' ' * 8, ' ...')


def _shape(shape: tuple[int, ...]) -> str:
    return f'({", ".join(str(length) for length in shape)}, n)'


def _help(title: str, *paragraphs: str) -> list[str]:
    """Return comment lines, which `help` shows."""
    lines = [f'%{title}']
    for paragraph in paragraphs:
        lines += [f'%   {line}'.rstrip() for line in folded(paragraph, _WIDTH, '  ').split('\n')]
    return lines


def _text(lines: list[str], last: str) -> str:
    return '\n'.join([*lines, last, ''])

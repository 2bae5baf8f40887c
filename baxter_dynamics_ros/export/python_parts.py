"""Parts that the exported Python files share, whatever library computes in them."""

from collections.abc import Callable
from math import prod

from .body import body_of, folded
from .functions import describe, Function
from .legend import FRAMES, head, parameters
from ..model.arm import BaxterArm

_WIDTH = 96
_INDENT = ' ' * 4

# What refuses parameters of another export, and names with a typing error.
CHECK = """
def _check(parameters):
    if parameters.keys() != PARAMETERS.keys():
        problems = [f'{word} {", ".join(map(str, names))}' for word, names in (
            ('unknown', [name for name in parameters if name not in PARAMETERS]),
            ('missing', [name for name in PARAMETERS if name not in parameters])) if names]
        raise ValueError(f'parameters: {"; ".join(problems)}; expected the names of PARAMETERS')
"""


def module_docstring(title: str, arm: BaxterArm, command: str, usage: str) -> str:
    """Return the docstring of a file: its title, the head, and how to use it."""
    paragraphs = (folded(paragraph, _WIDTH, '') for paragraph in (*head(arm, command), FRAMES))
    return '\n\n'.join([f'"""\n{title}', *paragraphs, usage.strip('\n') + '\n"""\n'])


def parameter_table(arm: BaxterArm) -> str:
    """Return PARAMETERS, this arm's numbers by name, each with its unit and meaning."""
    lines = [f'    {repr(p.name) + ": " + repr(p.value) + ",":<32}  # {p.unit}, {p.text}'
             for p in parameters(arm)]
    return '\n'.join(['PARAMETERS = {', *lines, '}\n'])


def function_docstring(function: Function, result: str, *more: str) -> list[str]:
    """Return the lines of a function's docstring."""
    outputs = '; '.join(f'{output.symbol} {_shape(output.shape)} [{output.unit}], {output.text}'
                        for output in function.quantity.outputs)
    inputs = '; '.join(f'{argument}: (7) {describe(argument)}'
                       for argument in function.arguments)
    paragraphs = (f'Return {result}{outputs}.', f'{inputs}.', *more,
                  f'{function.program.operations()} operations, beside sines and cosines.')
    lines = ['"""']
    for paragraph in paragraphs:
        lines += [*folded(paragraph, _WIDTH - 4, '').split('\n'), '']
    return [*lines[:-1], '"""']


def statements(function: Function, assign: Callable[[str, str], str] | None = None) -> list[str]:
    """
    Return the lines from parameters and elements to ``out``, a list of all outputs.

    Parameters
    ----------
    function : Function
        What to compute.
    assign : callable, optional
        Takes a temporary's name and its expression, and returns what to assign to it: the
        expression by default.

    """
    body = body_of(function, [f'out[{i}]' for i in range(function.size)])
    lines = []
    lines.append('_check(parameters)')
    if body.constants:
        names = ', '.join(body.constants)
        quoted = ', '.join(repr(name) for name in body.constants)
        lines += ['(', *_inside(names), ') = (parameters[name] for name in (', *_inside(quoted),
                  '))']
    lines.append(f'out = [0.0] * {function.size}')
    for target, expression in body.statements:
        if assign and not target.startswith('out['):
            expression = assign(target, expression)
        elif len(target) + len(expression) > _WIDTH - 8:
            expression = f'({expression})'
        lines += long(f'{target} = {expression}')
    return lines


def slices(function: Function) -> list[str]:
    """Return, for each output, what to write for its part of ``out``."""
    result, start = [], 0
    for output in function.quantity.outputs:
        end = start + prod(output.shape)
        result.append('out' if end - start == function.size else f'out[{start}:{end}]')
        start = end
    return result


def long(statement: str) -> list[str]:
    """Return the lines of a statement; what may be broken stands in brackets."""
    return folded(statement, _WIDTH - 4, _INDENT).split('\n')


def indented(lines: list[str]) -> str:
    """Return the lines of a function's body as text."""
    return '\n'.join(f'{_INDENT}{line}'.rstrip() for line in lines) + '\n'


def _inside(text: str) -> list[str]:
    return [_INDENT + line for line in folded(f'{text},', _WIDTH - 8, '').split('\n')]


def _shape(shape: tuple[int, ...]) -> str:
    return f'({", ".join(str(length) for length in shape)})'

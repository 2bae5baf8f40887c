"""SymPy: a Python file that returns matrices and the definitions they are written in."""

from .functions import COMMAND, Function
from .kernels import check_module
from .python_parts import (CHECK, function_docstring, indented, long, module_docstring,
                           parameter_table, slices, statements)
from ..model.arm import BaxterArm

_USAGE = """
Each function takes symbols, or q, qd, qdd and tau of this file, and returns (definitions,
result) as sympy.cse does: pairs (symbol, expression), each in terms of those before, and a
Matrix in terms of them, which keeps everything small. To use them:

    definitions, G = gravity()                    # this arm's numbers
    definitions, G = gravity(parameters=SYMBOLS)  # symbols for them, or any dictionary by name
    f = numeric([q], definitions, G)              # f(values): of one sequence of 7 numbers
    G = expanded(definitions, G)                  # one long expression, of tau a very long one

Substitute numbers in both: [(symbol, x.subs(values)) for symbol, x in definitions]. To have the
definitions of several functions together, give each a prefix of its own.
"""

_TOOLS = '''
def numeric(arguments, definitions, result):
    """
    Return result as a function of numbers, by sympy.lambdify.

    For arrays of many states make result a list of scalars, such as list(G).
    """
    return sympy.lambdify(arguments, result, cse=lambda _: (definitions, result))


def expanded(definitions, result):
    """Return result, or each of a tuple of results, with all definitions put in."""
    values = {}
    for symbol, expression in definitions:
        values[symbol] = sympy.sympify(expression).xreplace(values)
    if isinstance(result, (tuple, list)):
        return type(result)(each.xreplace(values) for each in result)
    return result.xreplace(values)


def _check_lengths(**vectors):
    for name, vector in vectors.items():
        if len(vector) != 7:
            raise ValueError(f'{name}: expected 7 symbols or numbers, got {len(vector)}')


def _definer(prefix):
    """Return a list, and a function that adds (symbol, expression) to it and returns symbol."""
    definitions = []

    def define(name, expression):
        symbol = sympy.Symbol(prefix + name, real=True)
        definitions.append((symbol, sympy.sympify(expression)))
        return symbol

    return definitions, define
'''


def files(functions: list[Function], arm: BaxterArm, name: str = 'baxter_dynamics',
          command: str = COMMAND) -> dict[str, str]:
    """
    Write a Python file for SymPy.

    Parameters
    ----------
    functions : list of Function
        What to write.
    arm : BaxterArm
        Whose numbers are the defaults.
    name : str, optional
        How the file's name begins.
    command : str, optional
        What writes them, for the files' heads.

    Returns
    -------
    dict
        File name -> text: ``name_sympy.py``.

    Raises
    ------
    ArgumentError
        If no module can have that name.

    """
    check_module(name)
    symbols = [f"{vector} = sympy.symbols('{vector}1:8', real=True)\n"
               for vector in ('q', 'qd', 'qdd', 'tau')]
    parts = [module_docstring('Dynamics of a Baxter arm as SymPy expressions.', arm, command,
                              _USAGE),
             '\nimport sympy\n\n', *symbols, '\n', parameter_table(arm),
             'SYMBOLS = {name: sympy.Symbol(name, real=True) for name in PARAMETERS}\n']
    parts += [f'\n\n{_definition(function)}' for function in functions]
    return {f'{name}_sympy.py': ''.join([*parts, '\n', _TOOLS, '\n', CHECK])}


def _definition(function: Function) -> str:
    symbols = ', '.join(output.symbol for output in function.quantity.outputs)
    several = len(function.quantity.outputs) > 1
    lines = function_docstring(function, f'definitions and ({symbols}): ' if several else
                               f'definitions and {symbols}: ')
    lines.append(f'_check_lengths({", ".join(f"{a}={a}" for a in function.arguments)})')
    lines += ['definitions, define = _definer(prefix)',
              "s1, s2, s3, s4, s5, s6, s7 = [define(f's{i + 1}', sympy.sin(q[i])) "
              'for i in range(7)]',
              "c1, c2, c3, c4, c5, c6, c7 = [define(f'c{i + 1}', sympy.cos(q[i])) "
              'for i in range(7)]']
    for argument in function.quantity.inputs:
        lines.append(f'{", ".join(f"{argument}{i}" for i in range(1, 8))} = {argument}')
    lines += statements(function, lambda target, text: f'define({target!r}, {text})')
    results = ', '.join(_result(output.shape, elements) for output, elements in
                        zip(function.quantity.outputs, slices(function)))
    lines += long(f'return definitions, {f"({results})" if several else results}')
    arguments = ', '.join(f'{argument}={argument}' for argument in function.arguments)
    return (f"def {function.quantity.name}({arguments}, parameters=PARAMETERS, prefix=''):\n"
            + indented(lines))


def _result(shape: tuple[int, ...], elements: str) -> str:
    lengths = ', '.join(str(length) for length in shape)
    return {1: f'sympy.Matrix({elements})', 2: f'sympy.Matrix({lengths}, {elements})',
            3: f'sympy.Array({elements}, ({lengths}))'}[len(shape)]

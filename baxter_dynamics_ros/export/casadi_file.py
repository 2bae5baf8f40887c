"""CasADi: a Python file that builds expressions and functions of SX."""

from math import prod

from .functions import COMMAND, Function
from .kernels import check_module
from .python_parts import (CHECK, function_docstring, indented, long, module_docstring,
                           parameter_table, slices, statements)
from ..model.arm import BaxterArm

_USAGE = """
Use, for each of FUNCTIONS, such as inverse_dynamics:

    tau = inverse_dynamics(q, qd, qdd)      # an expression, of vectors (7) of SX, MX or DM
    f = function('inverse_dynamics')        # a casadi.Function (q, qd, qdd) -> (tau)
    f = function('inverse_dynamics', None)  # ... (q, qd, qdd, parameters) -> (tau)

Parameters are a dictionary, numbers or symbols by name, and PARAMETERS, this arm's, by default;
function() takes numbers alone, or None. A casadi.Function takes them as a vector (n) in the order
of PARAMETERS. Called with matrices (7, n) it computes n states, and gives their results side by
side.
"""

_STACKED = 'h is a matrix (49, 7): h_ikm is in row 7 i + k, column m, counted from 0.'

_TOOLS = '''
def function(name, parameters=PARAMETERS):
    """
    Return a casadi.Function by the name of one of FUNCTIONS.

    Its inputs are vectors (7), its outputs as that function returns them, all named. Parameters,
    numbers by name, are built in; with None they are one more input.
    """
    compute, arguments, results = FUNCTIONS[name]
    inputs = {argument: casadi.SX.sym(argument, 7) for argument in arguments}
    if parameters is None:
        vector = casadi.SX.sym('parameters', len(PARAMETERS))
        parameters = dict(zip(PARAMETERS, casadi.vertsplit(vector)))
        outputs = compute(*inputs.values(), parameters)
        inputs['parameters'] = vector
    else:
        outputs = compute(*inputs.values(), parameters)
    outputs = outputs if isinstance(outputs, tuple) else (outputs,)
    return casadi.Function(name, list(inputs.values()), list(outputs), list(inputs), results)


def _split(vector):
    if vector.shape != (7, 1):
        raise ValueError(f'expected a vector (7), got {vector.shape}')
    return casadi.vertsplit(vector)


def _matrix(elements, rows, columns):
    """Return a matrix from its elements, row by row."""
    return casadi.reshape(casadi.vertcat(*elements), columns, rows).T
'''


def files(functions: list[Function], arm: BaxterArm, name: str = 'baxter_dynamics',
          command: str = COMMAND) -> dict[str, str]:
    """
    Write a Python file for CasADi.

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
        File name -> text: ``name_casadi.py``.

    Raises
    ------
    ArgumentError
        If no module can have that name.

    """
    check_module(name)
    parts = [module_docstring('Dynamics of a Baxter arm as CasADi expressions and functions.',
                              arm, command, _USAGE),
             '\nimport casadi\n\n', parameter_table(arm)]
    parts += [f'\n\n{_definition(function)}' for function in functions]
    parts += [f'\n\n{_table(functions)}\n', _TOOLS, '\n', CHECK]
    return {f'{name}_casadi.py': ''.join(parts)}


def _definition(function: Function) -> str:
    arguments = function.arguments
    notes = [_STACKED for output in function.quantity.outputs if len(output.shape) == 3]
    lines = function_docstring(function, '', *notes)
    lines += _elements('s', 'casadi.sin(q)') + _elements('c', 'casadi.cos(q)')
    for argument in arguments[1:]:
        lines += _elements(argument, argument)
    lines += statements(function)
    results = ', '.join(_result(output.shape, elements) for output, elements in
                        zip(function.quantity.outputs, slices(function)))
    lines += long(f'return ({results})' if len(function.quantity.outputs) > 1 else
                  f'return {results}')
    signature = f'def {function.quantity.name}({", ".join(arguments)}, parameters=PARAMETERS):\n'
    return signature + indented(lines)


def _elements(prefix: str, vector: str) -> list[str]:
    return [f'{", ".join(f"{prefix}{i}" for i in range(1, 8))} = _split({vector})']


def _result(shape: tuple[int, ...], elements: str) -> str:
    if len(shape) == 1:
        return f'casadi.vertcat(*{elements})'
    return f'_matrix({elements}, {prod(shape[:-1])}, {shape[-1]})'


def _table(functions: list[Function]) -> str:
    lines = ['# Name -> function, arguments, results.', 'FUNCTIONS = {']
    for function in functions:
        name, arguments = function.quantity.name, list(function.arguments)
        results = [output.symbol for output in function.quantity.outputs]
        lines += [f'    {line}' for line in long(f'{name!r}: ({name}, {arguments}, {results}),')]
    return '\n'.join([*lines, '}\n'])

"""Python with NumPy alone: one module, for one state or many."""

from .functions import COMMAND, Function
from .kernels import check_module, kernel
from .python_parts import (CHECK, function_docstring, indented, long, module_docstring,
                           parameter_table)
from ..model.arm import BaxterArm

_USAGE = """
Arguments are arrays (..., 7), whose leading axes are a batch and broadcast; results have the same
leading axes. Parameters are a dictionary of numbers by name, and PARAMETERS, this arm's, by
default: hand over another to change the arm, such as {**PARAMETERS, 'up_z': 1.62} on the moon.
"""

_IMPORTS = """
from math import cos
from math import sin
from operator import itemgetter

import numpy as np

BLOCK = 4096  # states computed at a time: small enough for the cache

"""

_COMPUTE = '''
_numbers = itemgetter(*PARAMETERS)


def _compute(kernel, shapes, parameters, *vectors):
    """Call a kernel: for one state with floats, for many with arrays, a block at a time."""
    if parameters is not PARAMETERS:
        _check(parameters)
    numbers = _numbers(parameters)
    vectors = [np.asarray(vector, float) for vector in vectors]
    for vector in vectors:
        if vector.shape[-1:] != (7,):
            raise ValueError(f'expected an array (..., 7), got {vector.shape}')
    if all(vector.ndim == 1 for vector in vectors):
        q, *rest = [vector.tolist() for vector in vectors]
        results = [[0.0] * _size(shape) for shape in shapes]
        kernel([sin(x) for x in q], [cos(x) for x in q], *rest, numbers, *results)
        leading, results = (), [np.array(result) for result in results]
    else:
        vectors = np.broadcast_arrays(*vectors)
        leading = vectors[0].shape[:-1]
        vectors = [vector.reshape(-1, 7) for vector in vectors]
        results = [np.empty((len(vectors[0]), _size(shape))) for shape in shapes]
        for start in range(0, len(vectors[0]), BLOCK):
            block = slice(start, start + BLOCK)
            q, *rest = [np.ascontiguousarray(vector[block].T) for vector in vectors]
            rows = [np.empty((_size(shape), q.shape[1])) for shape in shapes]
            kernel(np.sin(q), np.cos(q), *rest, numbers, *rows)
            for result, row in zip(results, rows):
                result[block] = row.T
    results = [result.reshape(leading + shape) for result, shape in zip(results, shapes)]
    return results[0] if len(results) == 1 else tuple(results)


def _size(shape):
    size = 1
    for length in shape:
        size *= length
    return size
'''


def files(functions: list[Function], arm: BaxterArm, name: str = 'baxter_dynamics',
          command: str = COMMAND) -> dict[str, str]:
    """
    Write functions in Python, which need NumPy alone.

    Parameters
    ----------
    functions : list of Function
        What to write.
    arm : BaxterArm
        Whose numbers are the defaults.
    name : str, optional
        Of the module.
    command : str, optional
        What writes them, for the files' heads.

    Returns
    -------
    dict
        File name -> text: ``name.py``.

    Raises
    ------
    ArgumentError
        If no module can have that name.

    """
    check_module(name)
    parts = [module_docstring('Dynamics of a Baxter arm, with NumPy alone.', arm, command, _USAGE),
             _IMPORTS, parameter_table(arm)]
    for function in functions:
        parts += ['\n\n', _definition(function), '\n\n', kernel(function, arm)]
    return {f'{name}.py': ''.join((*parts, '\n', _COMPUTE, '\n', CHECK))}


def _definition(function: Function) -> str:
    arguments = ', '.join(function.arguments)
    shapes = ', '.join(str(output.shape) for output in function.quantity.outputs)
    lines = function_docstring(function, '')
    lines += long(f'return _compute(_{function.quantity.name}, [{shapes}], parameters, '
                  f'{arguments})')
    return f'def {function.quantity.name}({arguments}, parameters=PARAMETERS):\n' + indented(lines)

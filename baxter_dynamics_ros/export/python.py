"""Export as a Python module for floats, arrays and symbols of any library."""

from textwrap import fill

from .generated import PATH
from .legend import FRAMES, head, parameters
from ..model.arm import BaxterArm

_USAGE = """
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


def files(arm: BaxterArm, command: str) -> dict[str, str]:
    """Return the exported file: its name -> its text."""
    text = PATH.read_text(encoding='utf-8')
    tables, functions = text[text.index('PARAMETERS = '):].split('\n\n\ndef ', 1)
    about = '\n\n'.join(fill(paragraph, 99) for paragraph in (*head(arm, command), FRAMES))
    values = ''.join(f'    {p.value!r},  # {p.name} [{p.unit}]: {p.text}\n'
                     for p in parameters(arm))
    return {'baxter_dynamics.py': ''.join([
        '# flake8: noqa\n', f'"""\nDynamics of a Baxter arm.\n\n{about}\n{_USAGE}"""\n\n', tables,
        f'\n# The exported arm.\nVALUES = (\n{values})\n\n\ndef ', functions, _EVALUATE])}

"""
The generated closed form compiled by numba: the very same source, for one state or many.

This is the one module that imports numba. A function is compiled when it is first called, which
takes seconds, and kept on disk, so that the next process loads it in a fraction of one.
"""

from collections.abc import Callable
from importlib import util
import sys
from types import FunctionType, ModuleType
from typing import TypeVar

import numba
import numpy as np

from .model import _closed_form
from .model.arrays import Array

_F = TypeVar('_F')
_BLOCK = 1024  # states computed at a time

# pi/2 in three parts, of which the first two have trailing zeros: no loss up to _LARGEST.
_HALF_PI_1, _HALF_PI_2, _HALF_PI_3 = (
    1.5707963267341256e+00, 6.0771005063039660e-11, 2.0222662487959506e-21)
_LARGEST = 1e5  # [rad]


def _jit(function: _F) -> _F:
    # There is no division by zero that would have to be seen.
    try:
        return numba.njit(cache=True, error_model='numpy')(function)
    except RuntimeError:  # no folder to keep it in: it is compiled in each process
        return numba.njit(error_model='numpy')(function)


@_jit
def sines_and_cosines(angles: Array, sines: Array, cosines: Array) -> None:
    """
    Write sin and cos of angles [rad] to arrays as long, to an error of 2e-16.

    Minimax polynomials on [-pi/4, pi/4], as in every C library (fdlibm's coefficients), but both
    at once and without branches or calls, so that the compiler takes several angles at a time.
    """
    for i in range(len(angles)):
        x = angles[i]
        quarter = np.rint(x * 0.6366197723675814)
        r = ((x - quarter * _HALF_PI_1) - quarter * _HALF_PI_2) - quarter * _HALF_PI_3
        z = r * r
        sine = r + r * z * (-1.66666666666666324348e-01 + z * (
            8.33333333332248946124e-03 + z * (-1.98412698298579493134e-04 + z * (
                2.75573137070700676789e-06 + z * (
                    -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))))
        cosine = 1.0 - 0.5 * z + z * z * (4.16666666666666019037e-02 + z * (
            -1.38888888888741095749e-03 + z * (2.48015872894767294178e-05 + z * (
                -2.75573143513906633035e-07 + z * (
                    2.08757232129817482790e-09 - z * 1.13596475577881948265e-11)))))
        quarter -= 4.0 * np.floor(0.25 * quarter)  # 0, 1, 2 or 3
        odd = quarter == 1.0 or quarter == 3.0
        s, c = (cosine if odd else sine), (sine if odd else cosine)
        sines[i] = -s if quarter >= 2.0 else s
        cosines[i] = -c if 1.0 <= quarter <= 2.0 else c
    for i in range(len(angles)):
        if abs(angles[i]) > _LARGEST:
            sines[i], cosines[i] = np.sin(angles[i]), np.cos(angles[i])


def _compile() -> ModuleType:
    """Return another instance of the generated module, with its functions compiled."""
    spec = util.spec_from_file_location(f'{__name__}._closed_form', _closed_form.__file__)
    assert spec is not None and spec.loader is not None  # it was loaded from there
    module = util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where numba looks for the functions that it kept
    spec.loader.exec_module(module)
    for name, function in list(vars(module).items()):
        if isinstance(function, FunctionType):
            setattr(module, name, _jit(function))  # they meet by their names
    return module


MODULE = _compile()  # the generated functions, compiled


def bind(name: str, size: int, constants: tuple[float, ...]) -> Callable[..., Array]:
    """Return what calls a compiled function, as ``model.closed_form.bind`` does."""
    row, rows = getattr(MODULE, f'{name}_row'), getattr(MODULE, f'{name}_rows')
    numbers = np.array(constants)

    def compute(q: Array, *rest: Array) -> Array:
        # numba would compile anew for arrays that are read-only or not contiguous.
        states = [x if x.flags.carray else x.copy() for x in (q, *rest)]
        if q.ndim > 1:
            return _compute_many(rows, size, numbers, *states)
        result = np.empty(size)
        row(*states, numbers, result)
        return result
    return compute


def _compute_many(rows: Callable[..., None], size: int, constants: Array, q: Array,
                  *rest: Array) -> Array:
    """Call a compiled function on arrays (n, 7), block by block."""
    result = np.empty((len(q), size))
    sines, cosines = np.empty((2, min(len(q), _BLOCK), q.shape[1]))
    for start in range(0, len(q), _BLOCK):
        angles, *others = (x[start:start + _BLOCK] for x in (q, *rest))
        n = len(angles)
        sines_and_cosines(angles.reshape(-1), sines[:n].reshape(-1), cosines[:n].reshape(-1))
        rows(sines[:n], cosines[:n], *others, constants, result[start:start + _BLOCK])
    return result

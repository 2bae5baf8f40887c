"""Engines of the closed form: compiled C, or Python with NumPy."""

from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.util import find_spec
from math import cos, isfinite, prod, sin
import os
from struct import Struct
from typing import Any
import warnings

import numpy as np

from . import _closed_form
from .arrays import Array, ArrayLike, finite
from .base_parameters import base_parameters, lengths
from .exceptions import ArgumentError
from .joints import N_JOINTS
from .parameters import ArmParameters, THETA_OFFSET

# Maps q and further vectors (..., 7) to an array or a tuple of arrays; validates its arguments.
Function = Callable[..., Any]

COMPILED, PYTHON, AUTO = ENGINES = ('compiled', 'python', 'auto')
ENGINE_VARIABLE = 'BAXTER_DYNAMICS_ENGINE'

_BLOCK = 4096  # number of states per block, so that temporaries stay in the cache
_STATE = (N_JOINTS,)
_FLOAT = np.dtype(float)
_to_list: Callable[[Any], Any] = np.ndarray.tolist


def choose_engine(engine: str) -> str:
    """Return 'compiled' or 'python' for one of :data:`ENGINES`, see :class:`.BaxterArm`."""
    source = 'engine'
    if engine == AUTO and os.environ.get(ENGINE_VARIABLE):
        source, engine = ENGINE_VARIABLE, os.environ[ENGINE_VARIABLE]
    if engine not in ENGINES:
        raise ArgumentError(source, f'expected one of {", ".join(ENGINES)}, got {engine!r}')
    if engine == PYTHON:
        return PYTHON
    try:
        import_module('._compiled', __package__)
    except ImportError as error:
        reason = (f'the compiled extension does not load ({error}); reinstall the package with a '
                  f'C++ compiler and pybind11, or choose {PYTHON!r}')
        if engine == COMPILED:
            raise ArgumentError(source, reason) from None
        if find_spec('._compiled', __package__):
            warnings.warn(f'{source}: {reason}; computing in Python', stacklevel=3)
        return PYTHON
    return COMPILED


def parameter_values(parameters: ArmParameters, pseudo_inertia: Array, gravity: Array,
                     mount: Array) -> tuple[float, ...]:
    """
    Return the values of ``_closed_form.PARAMETERS``.

    ``pseudo_inertia`` (7, 4, 4) is J of eq. (12) with any payload added to the last link, and
    ``gravity`` (3,) is in frame {0} [m/s^2].
    """
    a, d, alpha = (x.tolist() for x in (parameters.a, parameters.d, parameters.alpha))
    return (*base_parameters(parameters, pseudo_inertia).tolist(), *lengths(parameters),
            *(-gravity).tolist(), d[0], a[-1], d[-1], sin(alpha[-1]), cos(alpha[-1]),
            *mount[:3].ravel().tolist())


def functions(engine: str, values: tuple[float, ...], theta_offset: Array) -> dict[str, Function]:
    """
    Return the functions of the closed form for one arm, by their names in ``_closed_form``.

    ``values`` are those of :func:`parameter_values`, ``theta_offset`` is theta - q (7,) of eq. (2)
    [rad].
    """
    make: Callable[..., Function] = (import_module('._compiled', __package__).function
                                     if engine == COMPILED else _python_function)
    shift = theta_offset - THETA_OFFSET  # the generated functions have theta_2 = q_2 + pi/2
    result = {}
    for name, (vectors, outputs) in _closed_form.FUNCTIONS.items():
        names, shapes = ('q', *vectors), [output[1] for output in outputs]
        function = make(name, names, shapes, values, finite_batches)
        result[name] = _shifted(function, names, shift) if shift.any() else function
    return result


def finite_batches(names: Sequence[str], values: Sequence[ArrayLike]) -> list[Array]:
    """Return joint vectors as contiguous float arrays (..., 7), broadcast to one shape."""
    arrays = [finite(name, value, (..., N_JOINTS)) for name, value in zip(names, values)]
    try:
        broadcast = np.broadcast_arrays(*arrays)
    except ValueError:
        shapes = ', '.join(f'{name} {a.shape}' for name, a in zip(names, arrays))
        raise ArgumentError(', '.join(names), f'leading axes do not broadcast: {shapes}') from None
    return [np.require(array, float, ['C', 'A']) for array in broadcast]


def _shifted(function: Function, names: tuple[str, ...], shift: Array) -> Function:
    def call(*arguments: ArrayLike) -> Any:
        q, *rest = finite_batches(names, arguments)
        return function(q + shift, *rest)
    return call


def _python_function(name: str, names: tuple[str, ...], shapes: list[tuple[int, ...]],
                     parameters: tuple[float, ...], validate: Function) -> Function:
    """Return a function of ``_closed_form`` for one state (7,) or a batch (..., 7)."""
    function = getattr(_closed_form, name)
    size = sum(map(prod, shapes))
    write: Callable[..., None] = Struct(f'{size}d').pack_into

    def compute(*arguments: ArrayLike) -> Any:
        if not all(map(_is_state, arguments)):
            arrays = validate(names, arguments)
            return _split(_compute_many(function, size, parameters, arrays), shapes)
        q, *rest = map(_to_list, arguments)
        result = np.empty(size)
        write(result, 0, *function(map(sin, q), map(cos, q), *rest, parameters))
        return _split(result, shapes)
    return compute


def _is_state(value: object) -> bool:
    """Return whether a value is a finite float array (7,), which needs no conversion."""
    return (type(value) is np.ndarray and value.shape == _STATE and value.dtype is _FLOAT
            and isfinite(value.dot(value)))


def _split(result: Array, shapes: list[tuple[int, ...]]) -> Any:
    """Split the last axis into consecutive arrays of the given shapes."""
    if shapes == [_STATE]:
        return result
    batch, start, parts = result.shape[:-1], 0, []
    for shape in shapes:
        stop = start + prod(shape)
        parts.append(result[..., start:stop].reshape(batch + shape))
        start = stop
    return parts[0] if len(parts) == 1 else tuple(parts)


def _compute_many(function: Function, size: int, parameters: tuple[float, ...],
                  arrays: Sequence[Array]) -> Array:
    """Evaluate a generated function on arrays (..., 7), block by block."""
    rows = [x.reshape(-1, N_JOINTS) for x in arrays]
    n = len(rows[0])
    result = np.empty((n, size))
    block = np.empty((size, min(n, _BLOCK)))
    for start in range(0, n, _BLOCK):
        q, *rest = (np.ascontiguousarray(x[start:start + _BLOCK].T) for x in rows)
        out = block[:, :q.shape[1]]
        tangent = np.tan(0.5 * q)  # one transcendental function for sine and cosine
        square = tangent * tangent
        factor = 1.0 / (1.0 + square)
        sine, cosine = (tangent + tangent) * factor, (1.0 - square) * factor
        for row, value in zip(out, function(sine, cosine, *rest, parameters)):
            row[:] = value
        result[start:start + _BLOCK] = out.T
    return result.reshape(arrays[0].shape[:-1] + (size,))

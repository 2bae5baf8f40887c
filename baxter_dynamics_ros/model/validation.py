"""Validation of arguments: finite arrays of a given shape, or an error that names the argument."""

from collections.abc import Sequence

import numpy as np

from .arrays import Array, ArrayLike
from .exceptions import ArgumentError
from .joints import N_JOINTS


def finite(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """
    Return ``value`` as a float array of exactly ``shape``.

    Raises
    ------
    ArgumentError
        If the value is not numeric, has another shape, or is not finite.

    """
    array = _real(name, value)
    if array.shape != shape:
        raise ArgumentError(name, f'expected shape {shape}, got {array.shape}')
    return _finite(name, array)


def finite_batches(names: Sequence[str], values: Sequence[ArrayLike]) -> list[Array]:
    """
    Return joint vectors as contiguous float arrays (..., 7), broadcast to one shape.

    Raises
    ------
    ArgumentError
        If a value is not numeric, has no last axis of 7, or is not finite, or if the leading axes
        do not broadcast.

    """
    arrays = [_real(name, value) for name, value in zip(names, values)]
    for name, array in zip(names, arrays):
        if array.shape[-1:] != (N_JOINTS,):
            raise ArgumentError(name, f'expected shape (..., {N_JOINTS}), got {array.shape}')
        _finite(name, array)
    try:
        broadcast = np.broadcast_arrays(*arrays)
    except ValueError:
        shapes = ', '.join(f'{name} {a.shape}' for name, a in zip(names, arrays))
        raise ArgumentError(', '.join(names),
                            f'leading axes do not broadcast: {shapes}') from None
    return [np.require(array, float, ['C', 'A']) for array in broadcast]


def number(name: str, value: ArrayLike, lower: float = -np.inf, upper: float = np.inf,
           unit: str = '') -> float:
    """
    Return ``value`` as a finite float in [lower, upper]; ``unit`` is for the error.

    Raises
    ------
    ArgumentError
        If it is not a number, not finite, or out of range.

    """
    result = float(finite(name, value, ()))
    if not lower <= result <= upper:
        range_ = f'[{lower:g}, {upper:g}] {unit}'.rstrip()
        raise ArgumentError(name, f'expected a value in {range_}, got {result:g}')
    return result


def _real(name: str, value: ArrayLike) -> Array:
    try:
        array = np.asarray(value)
        if array.dtype.kind not in 'fiu':
            raise TypeError(f'dtype {array.dtype}')
        return array.astype(float, copy=False)
    except (TypeError, ValueError) as error:
        raise ArgumentError(name, f'expected real numbers ({error})') from None


def _finite(name: str, array: Array) -> Array:
    if not np.isfinite(array).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ArgumentError(name, f'expected finite values, got {array[index]} at index {index}')
    return array

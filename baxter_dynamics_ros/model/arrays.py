"""Array types for annotations, and validation of arguments, whose errors name the argument."""

from types import EllipsisType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .exceptions import ArgumentError

__all__ = ['Array', 'ArrayLike', 'Bools', 'finite', 'Indices', 'read_only', 'rms']

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.integer[Any]]  # integers: indices, stamps


def finite(name: str, value: ArrayLike, *shapes: tuple[int | EllipsisType, ...]) -> Array:
    """Return finite real numbers of a shape, (3,) or (..., 7) for example, as a float array."""
    try:
        array = np.asarray(value)
        if array.dtype.kind not in 'fiu':
            raise TypeError(f'dtype {array.dtype}')
        array = array.astype(float, copy=False)
    except (TypeError, ValueError) as error:
        raise ArgumentError(name, f'expected real numbers ({error})') from None
    if not any((array.shape[-1:] == shape[1:]) if ... in shape else (array.shape == shape)
               for shape in shapes):
        expected = ' or '.join(map(str, shapes)).replace('Ellipsis', '...')
        raise ArgumentError(name, f'expected shape {expected}, got {array.shape}')
    if not np.isfinite(array).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ArgumentError(name, f'expected finite values, got {array[index]} at index {index}')
    return array


def read_only(array: Array) -> Array:
    """Return an array after making it read-only."""
    array.flags.writeable = False
    return array


def rms(values: ArrayLike) -> Array:
    """Return the root of the mean square over the first axis."""
    return np.sqrt(np.mean(np.square(values), axis=0))

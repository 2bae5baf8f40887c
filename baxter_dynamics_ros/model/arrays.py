"""Array types for annotations; docstrings state the shapes."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ['Array', 'ArrayLike', 'Bools', 'Indices']

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.integer[Any]]  # integers: indices, stamps

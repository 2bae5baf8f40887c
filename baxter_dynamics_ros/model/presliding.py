r"""
Friction with a memory: Dahl's model of how far each joint has come from sticking to sliding.

A joint that turns round does not feel the full friction of the other direction at once: the
bristles of the contact bend first, over some hundredths of a radian. Dahl's state z in [-1, 1]
follows ``dz/dq = (1 - z sign(qd)) / length``. It knows angles and no time, and over a step in
one direction the solution is exact: z goes to that direction's sign by
``exp(-|change of q| / length)``. On Baxter it is what shows as hysteresis at s1.
"""

import numpy as np

from .arrays import Array
from .joints import N_JOINTS


class Presliding:
    """
    Dahl's state of the seven joints; friction is ``dahl * z``.

    Parameters
    ----------
    length : float, or array_like (m, 1)
        The angle over which friction turns round [rad], or several to compare.

    Attributes
    ----------
    z : ndarray (7,), or (m, 7)
        The state: -1 or 1 where the joint slides, 0 where nothing is known yet.

    """

    def __init__(self, length: Array | float) -> None:
        self.length = length
        self.reset()

    def reset(self) -> None:
        """Forget the past: no friction until the joints move."""
        self._q: Array | None = None
        self.z = np.zeros(np.broadcast_shapes(np.shape(self.length), (N_JOINTS,)))

    def update(self, q: Array) -> Array:
        """Move to q (7,) [rad], straight from the last; return z."""
        if self._q is not None:
            step = q - self._q
            direction = np.sign(step)
            self.z = direction + (self.z - direction) * np.exp(np.abs(step) / -self.length)
        self._q = q
        return self.z

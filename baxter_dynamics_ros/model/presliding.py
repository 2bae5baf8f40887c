r"""
Dahl's model of pre-sliding friction: the transition from sticking to sliding.

A joint that reverses does not feel the full friction of the new direction at once: the contact
first deflects over a few hundredths of a radian. Dahl's state z in [-1, 1] follows
``dz/dq = (1 - z sign(qd)) / length``, which depends on angles, not on time. For a step in one
direction the solution is exact: z approaches the direction's sign by
``exp(-|change of q| / length)``. On Baxter it explains the hysteresis at s1.
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
        Angle over which friction reverses [rad], or several to compare.

    Attributes
    ----------
    z : ndarray (7,), or (m, 7)
        State: -1 or 1 while the joint slides, 0 while unknown.

    """

    def __init__(self, length: Array | float) -> None:
        self.length = length
        self.reset()

    def reset(self) -> None:
        """Forget the history: no friction until the joints move."""
        self._q: Array | None = None
        self.z = np.zeros(np.broadcast_shapes(np.shape(self.length), (N_JOINTS,)))

    def update(self, q: Array) -> Array:
        """Advance to q (7,) [rad] and return z."""
        if self._q is not None:
            step = q - self._q
            direction = np.sign(step)
            self.z = direction + (self.z - direction) * np.exp(np.abs(step) / -self.length)
        self._q = q
        return self.z

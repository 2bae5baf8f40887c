"""A base that does not stand level: the gravity vector in its frame."""

import numpy as np

from .arrays import Array, ArrayLike


def gravity_in_base(gravity: ArrayLike, roll: float, pitch: float) -> Array:
    """
    Return the gravity vector in the axes of a tilted base (3,) [m/s^2].

    Parameters
    ----------
    gravity : array_like (3,)
        The gravity vector in level axes, z up [m/s^2].
    roll, pitch : float
        Of the base against level axes, fixed-axis as REP-103 has it: first roll about x, then
        pitch about y [rad]. Positive roll lifts the robot's left, positive pitch lowers its front.

    """
    (sr, sp), (cr, cp) = np.sin([roll, pitch]), np.cos([roll, pitch])
    base = np.array([[cp, sp * sr, sp * cr],
                     [0.0, cr, -sr],
                     [-sp, cp * sr, cp * cr]])  # axes of the base as columns
    return base.T @ np.asarray(gravity, dtype=float)

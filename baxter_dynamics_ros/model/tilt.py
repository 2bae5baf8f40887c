"""Gravity vector in the frame of a tilted base."""

import numpy as np

from .arrays import Array, ArrayLike


def gravity_in_base(gravity: ArrayLike, roll: float, pitch: float) -> Array:
    """
    Return the gravity vector in the axes of a tilted base (3,) [m/s^2].

    Parameters
    ----------
    gravity : array_like (3,)
        Gravity vector in level axes, z up [m/s^2].
    roll, pitch : float
        Orientation of the base, fixed axes as in REP-103: roll about x, then pitch about y [rad].
        Positive roll raises the robot's left side, positive pitch lowers its front.

    """
    (sr, sp), (cr, cp) = np.sin([roll, pitch]), np.cos([roll, pitch])
    base = np.array([[cp, sp * sr, sp * cr],
                     [0.0, cr, -sr],
                     [-sp, cp * sr, cp * cr]])  # axes of the base as columns
    return base.T @ np.asarray(gravity, dtype=float)

"""Hand wrench that explains an external joint torque."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from ..model.arrays import Array

# Length that scales torques to forces: about the distance from the wrist to the hand frame [m].
LEVER = 0.25
# Smallest singular value of the scaled Jacobian for which a wrench is returned [m].
LEAST_SINGULAR_VALUE = 0.02
_SCALE = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])
_ROW_SCALE = _SCALE[:, None].copy()


class HandWrench(NamedTuple):
    """External wrench on the hand; read-only arrays (3,), base axes."""

    force: Array  # [N]
    torque: Array  # about the origin of the hand frame [N m]
    unexplained: float  # norm of the external torque that no hand wrench explains [N m]


def hand_wrench(jacobian: Array, external: Array) -> 'HandWrench | None':
    """
    Return the wrench w with J^T w = r, by least squares.

    Near a singularity some wrenches cause almost no joint torque. None is returned where errors of
    0.1 N m per joint (standard deviation) in r could cause an error above 5 N, or 1.25 N m, in
    some direction: in 18 % of random postures within the limits, two thirds of them with the elbow
    nearly straight (e1 below 0.3 rad), and nowhere on the paper's three trajectories, where the
    error is at most 0.6 N and 0.3 N m.

    ``unexplained`` is the component of r along the arm's self-motion, in which the hand does not
    move. It is zero for a push on the hand, and nonzero for a push on the elbow in the direction
    in which the elbow can swing.

    Parameters
    ----------
    jacobian : ndarray (6, 7)
        Jacobian of the hand, linear rows first, see :meth:`.BaxterArm.jacobian`.
    external : ndarray (7,)
        External torque r on the joints [N m], finite.

    Returns
    -------
    HandWrench or None
        External wrench on the hand; None near a singularity.

    """
    scaled = jacobian * _ROW_SCALE
    squares, directions = np.linalg.eigh(scaled.dot(scaled.T))
    if squares[0] < LEAST_SINGULAR_VALUE ** 2:
        return None
    wrench = directions.dot(scaled.dot(external).dot(directions) / squares) * _SCALE
    wrench.setflags(write=False)
    rest = external - wrench.dot(jacobian)
    return HandWrench(wrench[:3], wrench[3:], sqrt(rest.dot(rest)))

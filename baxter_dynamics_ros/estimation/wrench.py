"""From external joint torque to the wrench at the hand that explains it, where there is one."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from ..model.arrays import Array

# A force and a torque are compared by the distance from the wrist to the hand frame, about [m].
LEVER = 0.25
# Of the Jacobian with its angular rows times the lever; below it no wrench is told [m].
LEAST_SINGULAR_VALUE = 0.02
_SCALE = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])
_ROW_SCALE = _SCALE[:, None].copy()


class HandWrench(NamedTuple):
    """What the environment exerts on the hand; read-only arrays (3,), base axes."""

    force: Array  # [N]
    torque: Array  # about the hand frame's origin [N m]
    unexplained: float  # norm of the joint torque that no wrench at the hand explains [N m]


def hand_wrench(jacobian: Array, external: Array) -> 'HandWrench | None':
    """
    Return the wrench w that explains external torque r best: J^T w = r, by least squares.

    Near a singularity the joints hardly feel some wrench. None is told where errors in r of 0.1
    N m a joint (standard deviation) could make an error above 5 N, or 1.25 N m, in some direction:
    in 18 % of random postures within the limits, two thirds of them with the elbow nearly
    straight (e1 below 0.3 rad), and nowhere on the paper's three trajectories, where the error is
    0.6 N and 0.3 N m at most.

    Seven joints feel six components; what is left over, ``unexplained``, is the part of r along
    the arm's self-motion, in which the hand rests. A push on the hand has no such part. One on
    the elbow has, unless it is across the direction in which the elbow can swing.

    Parameters
    ----------
    jacobian : ndarray (6, 7)
        Of the hand, with linear rows first, as ``model.hand`` gives it.
    external : ndarray (7,)
        Torque r that the environment exerts on the joints [N m], finite.

    Returns
    -------
    HandWrench or None
        What the environment exerts on the hand; None near a singularity.

    """
    scaled = jacobian * _ROW_SCALE
    squares, directions = np.linalg.eigh(scaled.dot(scaled.T))
    if squares[0] < LEAST_SINGULAR_VALUE ** 2:
        return None
    wrench = directions.dot(scaled.dot(external).dot(directions) / squares) * _SCALE
    wrench.setflags(write=False)
    rest = external - wrench.dot(jacobian)
    return HandWrench(wrench[:3], wrench[3:], sqrt(rest.dot(rest)))

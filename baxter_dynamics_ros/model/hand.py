"""Pose and Jacobian of the hand for one state, in plain floats: fast enough for every message."""

from collections.abc import Callable
from math import cos, sin
from struct import Struct

import numpy as np

from .arrays import Array
from .base_parameters import lengths
from .joints import N_JOINTS
from .parameters import ArmParameters

_Vector = tuple[float, float, float]
_Chain = tuple[list[tuple[float, ...]], tuple[_Vector, _Vector, _Vector], _Vector]
_COLUMNS = (N_JOINTS, 6)
_write: Callable[..., None] = Struct(f'{N_JOINTS * 6}d').pack_into  # twice as fast as np.array


class HandKinematics:
    """
    Where the hand is and how it moves, as :class:`BaxterArm` says it, for one state and sooner.

    Joints 1 and 2, 3 and 4, 5 and 6 are pairs, whose axes are at right angles: two rotations of
    two vectors each instead of two products of matrices. Inputs are float arrays (7,) [rad],
    finite; nothing is checked here.

    Parameters
    ----------
    parameters : ArmParameters
        Whose d, a, alpha and theta_offset place the frames.
    mount : ndarray (4, 4)
        Pose of the paper's frame {0} in the base frame, a rigid transform.

    Raises
    ------
    ArgumentError
        If the arm is not built like Baxter's.

    """

    def __init__(self, parameters: ArmParameters, mount: Array) -> None:
        lengths(parameters)  # refuses an arm whose joints are no such pairs
        a, d = parameters.a.tolist(), parameters.d.tolist()
        self._offset = parameters.theta_offset
        self._pairs = tuple(zip(a[:6:2], d[:6:2]))  # of joints 1, 3, 5; those of 2, 4, 6 are zero
        self._last = a[6], d[6], sin(parameters.alpha[6]), cos(parameters.alpha[6])
        self._mount = tuple(map(tuple, mount[:3].T.tolist()))  # axes x, y, z and origin

    def pose(self, q: Array) -> Array:
        """Return the pose of the hand in the base frame, (4, 4), translation in m."""
        _, axes, origin = self._chain(q)
        result = np.empty((4, 4))
        result[:3] = np.array((*axes, origin)).T
        result[3] = 0.0, 0.0, 0.0, 1.0
        return result

    def jacobian(self, q: Array) -> Array:
        """
        Return the geometric Jacobian of the hand in the base frame, (6, 7).

        Rows 0 to 2 give the velocity of the hand frame's origin [m/s], rows 3 to 5 the angular
        velocity of the hand [rad/s], both with base-frame axes.
        """
        joints, _, (px, py, pz) = self._chain(q)
        columns: list[float] = []
        for zx, zy, zz, ox, oy, oz in joints:
            x, y, z = px - ox, py - oy, pz - oz
            columns += zy * z - zz * y, zz * x - zx * z, zx * y - zy * x, zx, zy, zz
        result = np.empty(_COLUMNS)
        _write(result, 0, *columns)
        return result.T

    def _chain(self, q: Array) -> _Chain:
        """Return each joint's axis and a point on it, the hand's axes x, y, z, and its origin."""
        theta = (q + self._offset).tolist()
        s, c = [*map(sin, theta)], [*map(cos, theta)]
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz), (px, py, pz) = self._mount
        joints: list[tuple[float, ...]] = []
        for (a, d), s1, c1, s2, c2 in zip(self._pairs, s[::2], c[::2], s[1::2], c[1::2]):
            joints.append((zx, zy, zz, px, py, pz))
            # Eq. (2) with alpha = -90 degrees: x becomes u, and the next joint turns about v.
            ux, uy, uz = c1 * xx + s1 * yx, c1 * xy + s1 * yy, c1 * xz + s1 * yz
            vx, vy, vz = c1 * yx - s1 * xx, c1 * yy - s1 * xy, c1 * yz - s1 * xz
            px, py, pz = px + a * ux + d * zx, py + a * uy + d * zy, pz + a * uz + d * zz
            joints.append((vx, vy, vz, px, py, pz))
            # ... and with +90 degrees.
            xx, xy, xz = c2 * ux - s2 * zx, c2 * uy - s2 * zy, c2 * uz - s2 * zz
            zx, zy, zz = s2 * ux + c2 * zx, s2 * uy + c2 * zy, s2 * uz + c2 * zz
            yx, yy, yz = vx, vy, vz
        joints.append((zx, zy, zz, px, py, pz))
        a, d, sa, ca = self._last
        s1, c1 = s[6], c[6]
        ux, uy, uz = c1 * xx + s1 * yx, c1 * xy + s1 * yy, c1 * xz + s1 * yz
        vx, vy, vz = c1 * yx - s1 * xx, c1 * yy - s1 * xy, c1 * yz - s1 * xz
        axes = ((ux, uy, uz),
                (ca * vx + sa * zx, ca * vy + sa * zy, ca * vz + sa * zz),
                (ca * zx - sa * vx, ca * zy - sa * vy, ca * zz - sa * vz))
        return joints, axes, (px + a * ux + d * zx, py + a * uy + d * zy, pz + a * uz + d * zz)

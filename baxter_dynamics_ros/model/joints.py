"""Joints of an arm: names, order and limits; mounting poses of the arms, tilt of the base."""

from itertools import compress

import numpy as np

from .arrays import Array, ArrayLike, Bools, read_only
from .exceptions import ArgumentError

# Joint order of all arrays in this package.
JOINTS = ('s0', 's1', 'e0', 'e1', 'w0', 'w1', 'w2')
N_JOINTS = len(JOINTS)
S1 = JOINTS.index('s1')  # the joint that carries the parallel springs

SIDES = ('right', 'left')
BASE_FRAME = 'base'  # the robot's name for the frame in which mount() returns poses

# Joint limits in the manufacturer's robot description [rad].
POSITION_LOWER = read_only(np.array(
    [-1.70167993878, -2.147, -3.05417993878, -0.05, -3.059, -1.57079632679, -3.059]))
POSITION_UPPER = read_only(np.array(
    [1.70167993878, 1.047, 3.05417993878, 2.618, 3.059, 2.094, 3.059]))

_STOP = 0.05  # distance from the limit at which a joint may be at its stop [rad]

# Maximum joint speeds in the manufacturer's hardware specification [rad/s].
VELOCITY_LIMIT = read_only(np.array([2.0, 2.0, 2.0, 2.0, 4.0, 4.0, 4.0]))


def joint_names(side: str) -> tuple[str, ...]:
    """
    Return the seven ROS joint names of one arm, in the package's joint order.

    ArgumentError is raised if side is neither 'right' nor 'left'.
    """
    if side not in SIDES:
        raise ArgumentError('side', f'expected one of {", ".join(SIDES)}, got {side!r}')
    return tuple(f'{side}_{joint}' for joint in JOINTS)


def names_of(where: Bools) -> tuple[str, ...]:
    """Return the joints at which an array (7,) is true."""
    return tuple(compress(JOINTS, where))


def mount(side: str) -> Array:
    """
    Return the pose (4, 4) of the paper's frame {0} of one arm in the robot's ``base``, in m.

    Source: the manufacturer's robot description (``right_torso_arm_mount`` and ``right_s0``,
    and their left twins). The arms differ only in the sign of the yaw and of y. ArgumentError is
    raised if side is neither 'right' nor 'left'.
    """
    joint_names(side)  # validates side
    sign = 1.0 if side == 'left' else -1.0
    yaw = sign * 0.7854  # rad
    c, s = np.cos(yaw), np.sin(yaw)
    shoulder = np.array([0.055695, 0.0, 0.011038])
    pose = np.eye(4)
    pose[:3, :3] = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
    pose[:3, 3] = [0.024645, sign * 0.219645, 0.118588] + pose[:3, :3] @ shoulder
    return pose


def stops(q: Array) -> Array:
    """Return 1 for joints at the upper stop, -1 at the lower one, else 0, for q (..., 7) [rad]."""
    return (q > POSITION_UPPER - _STOP).astype(float) - (q < POSITION_LOWER + _STOP)


def gravity_in_base(gravity: ArrayLike, roll: float, pitch: float) -> Array:
    """
    Return a gravity vector of level axes, z up (3,) [m/s^2], in the axes of a tilted base.

    Roll turns the base about x, then pitch about y [rad], fixed axes as in REP-103: positive roll
    raises the robot's left side, positive pitch lowers its front.
    """
    (sr, sp), (cr, cp) = np.sin([roll, pitch]), np.cos([roll, pitch])
    base = np.array([[cp, sp * sr, sp * cr],
                     [0.0, cr, -sr],
                     [-sp, cp * sr, cp * cr]])  # axes of the base as columns
    return base.T @ np.asarray(gravity, dtype=float)

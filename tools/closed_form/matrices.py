"""Products of 4 x 4 matrices in one body frame, reduced to the elements that wrenches need."""

from typing import NamedTuple

from .frames import (add, Affine, apply, cross, dot, Matrix, PseudoInertia, Scalar, Twist, Vector,
                     Wrench, ZERO)


class Acceleration(NamedTuple):
    """A_l of eq. (5) in body frame l: an affine matrix, and differences of its diagonal."""

    block: Matrix  # dW/dt + W W, with W = skew(omega)
    column: Vector  # acceleration of the origin, less gravity
    spread: Vector  # zz - yy, xx - zz, yy - xx of the block


def acceleration(omega: Vector, omega_dot: Vector, column: Vector) -> Acceleration:
    """Return A of a body that turns with omega and omega_dot."""
    (x, y, z), (dx, dy, dz) = omega, omega_dot
    xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
    block = ((-(yy + zz), xy - dz, xz + dy), (xy + dz, -(xx + zz), yz - dx),
             (xz - dy, yz + dx, -(xx + yy)))
    return Acceleration(block, column, (zz - yy, xx - zz, yy - xx))


def twist_matrix(omega: Vector, velocity: Vector) -> Acceleration:
    """Return V of a twist in the form of an acceleration; its diagonal is zero."""
    x, y, z = omega
    return Acceleration(((0, -z, y), (z, 0, -x), (-y, x, 0)), velocity, ZERO)


def change_with_axis(a: Acceleration) -> Acceleration:
    """Return A xi - xi A: derivative of A_k with respect to q_k, in body frame k."""
    (_, xy, xz), (yx, _, yz), (zx, zy, _) = a.block
    sum_, difference = xy + yx, a.spread[2]
    block = ((sum_, difference, yz), (difference, -sum_, -xz), (zy, -zx, 0))
    return Acceleration(block, (a.column[1], -a.column[0], 0), (sum_, sum_, -(sum_ + sum_)))


def derivative_of_axis(omega: Vector, velocity: Vector) -> Twist:
    """Return dxi/dt = V xi - xi V in the joint's body frame, as a twist (angular, linear)."""
    return (omega[1], -omega[0], 0), (velocity[1], -velocity[0], 0)


def turned(j: PseudoInertia) -> Affine:
    """Return xi J."""
    return Affine(((-j.xy, -j.yy, -j.yz), (j.xx, j.xy, j.xz), ZERO), (-j.hy, j.hx, 0))


def spun(omega: Vector, matrix: Affine) -> Affine:
    """Return V X; the linear velocity has no effect, because the last row of X is zero."""
    columns = [cross(omega, column) for column in zip(*matrix.block)]
    return Affine(tuple(zip(*columns)), cross(omega, matrix.column))


def wrench_of(matrix: Affine) -> Wrench:
    """Return the wrench of X."""
    (_, xy, xz), (yx, _, yz), (zx, zy, _) = matrix.block
    return Wrench((zy - yz, xz - zx, yx - xy), matrix.column)


def axis_wrench(matrix: Affine) -> Wrench:
    """Return the wrench of xi X."""
    (xx, _, xz), (_, yy, yz), _ = matrix.block
    return Wrench((-xz, -yz, xx + yy), (-matrix.column[1], matrix.column[0], 0))


def axis_moment_of_transpose(matrix: Affine) -> Vector:
    """Return the moment of xi X^T, which has no force; that of X xi^T is its opposite."""
    (xx, _, _), (_, yy, _), (zx, zy, _) = matrix.block
    return -zx, -zy, xx + yy


def acceleration_wrench(a: Acceleration, j: PseudoInertia) -> Wrench:
    """Return the wrench of A J."""
    (_, xy, xz), (yx, _, yz), (zx, zy, _) = a.block
    moment = (zx * j.xy - yx * j.xz + zy * j.yy - yz * j.zz + a.spread[0] * j.yz,
              xy * j.yz - zy * j.xy + xz * j.zz - zx * j.xx + a.spread[1] * j.xz,
              yz * j.xz - xz * j.yz + yx * j.xx - xy * j.yy + a.spread[2] * j.xy)
    first = j.hx, j.hy, j.hz
    return Wrench(add(moment, cross(first, a.column)), apply(a.block, first))


def moment_of_moving_transpose(omega: Vector, velocity: Vector, h: PseudoInertia,
                               d: Affine) -> Vector:
    """Return the moment of xi B^T, for B = V H + D."""
    (wx, wy, _), (vx, vy, vz) = omega, velocity
    x, y, z = axis_moment_of_transpose(d)
    # The products with omega_z cancel in the sum x x + y y.
    return (x - (wx * h.xy - wy * h.xx + vz * h.hx), y - (wx * h.yy - wy * h.xy + vz * h.hy),
            z + (wy * h.xz - wx * h.yz + vx * h.hx + vy * h.hy))


def unit_torques(twist: Twist, a: Acceleration) -> list[Scalar]:
    """Return the torques of unit xx yy xy xz yz hx hy of a link at the joint of a twist."""
    units = (PseudoInertia(**{name: 1}) for name in ('xx', 'yy', 'xy', 'xz', 'yz', 'hx', 'hy'))
    return [pair(twist, acceleration_wrench(a, unit)) for unit in units]


def pair(twist: Twist, w: Wrench) -> Scalar:
    """Return <X, xi>, of the wrench of X."""
    return dot(twist[0], w.moment) + dot(twist[1], w.force)


def change_on(change: Acceleration, p: Affine) -> Scalar:
    """Return <X, P>, for the change of an acceleration, whose diagonal is (t, -t, 0)."""
    (t, xy, xz), (_, _, yz), (zx, zy, _) = change.block
    b = p.block
    return (t * (b[0][0] - b[1][1]) + xy * (b[0][1] + b[1][0]) + xz * b[0][2] + yz * b[1][2]
            + zx * b[2][0] + zy * b[2][1] + dot(change.column, p.column))


def total(x: Wrench, y: Wrench) -> Wrench:
    """Return x + y."""
    return Wrench(add(x.moment, y.moment), add(x.force, y.force))


def about_axis(v: Vector) -> Vector:
    """Return z cross v."""
    return -v[1], v[0], 0

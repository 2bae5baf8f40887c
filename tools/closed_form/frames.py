"""
Body frames: quantities in them, products, and the transformations between frames.

*Body frame* k has the axis of joint k as its z axis and the origin of the paper's frame {k-1}, and
rotates with link k: 0T_{k-1} Rz(theta_k). In it the twist xi_k of joint k is Q itself, eq. (9).
For Baxter the transformation to the next body frame is a shift (a, 0, d) and a rotation by +-90
degrees about x, which only swaps axes.

Scalars are floats, NumPy arrays or symbols; structural zeros are the integer 0, which a symbolic
library removes. Vectors are tuples (x, y, z), matrices tuples of rows. Indices count from 0.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

Scalar = Any
Scalars = Sequence[Scalar]
Vector = tuple[Scalar, ...]  # x, y, z
Twist = tuple[Vector, Vector]  # angular, linear
Matrix = tuple[Vector, ...]  # rows
Rows = list[list[Scalar]]

N = 7
# Sign of alpha of links 1 to 6, Table II: -90 or +90 degrees.
_ALPHA = (-1, 1, -1, 1, -1, 1)

ZERO: Vector = (0, 0, 0)
ZERO_MATRIX: Matrix = (ZERO, ZERO, ZERO)


class PseudoInertia(NamedTuple):
    """J of eq. (12) without a mass: second moments x x to y z, first moments h. Symmetric."""

    xx: Scalar = 0
    yy: Scalar = 0
    zz: Scalar = 0
    xy: Scalar = 0
    xz: Scalar = 0
    yz: Scalar = 0
    hx: Scalar = 0
    hy: Scalar = 0
    hz: Scalar = 0


class Wrench(NamedTuple):
    """Wrench of a matrix X, which determines <X, xi>: moment about the origin, and force."""

    moment: Vector = ZERO
    force: Vector = ZERO


class Affine(NamedTuple):
    """A 4 x 4 matrix whose last row is zero: its 3 x 3 block and its last column."""

    block: Matrix = ZERO_MATRIX
    column: Vector = ZERO


class Acceleration(NamedTuple):
    """A_l of eq. (5) in body frame l: an affine matrix, and differences of its diagonal."""

    block: Matrix  # dW/dt + W W, with W = skew(omega)
    column: Vector  # acceleration of the origin, less gravity
    spread: Vector  # zz - yy, xx - zz, yy - xx of the block


class Frames:
    """Transformations between body frames at one configuration."""

    def __init__(self, sine: Scalars, cosine: Scalars, lengths: Sequence[Scalars]) -> None:
        self._turns = list(zip(sine, cosine))  # of theta
        self._lengths = lengths  # a and d [m] of links 1 to 6

    def shift(self, k: int) -> Vector:
        """Return the origin of body frame k + 1 in body frame k."""
        a, d = self._lengths[k]
        return a, 0, d

    def outward(self, k: int, v: Vector) -> Vector:
        """Rotate a vector from body frame k - 1 (frame {0} for k = 0) to body frame k."""
        s, c = self._turns[k]
        x, y, z = _swap(-_ALPHA[k - 1], v) if k else v
        return c * x + s * y, c * y - s * x, z

    def inward(self, k: int, v: Vector) -> Vector:
        """Rotate a vector from body frame k to body frame k - 1."""
        s, c = self._turns[k]
        x, y, z = v
        return _swap(_ALPHA[k - 1], (c * x - s * y, s * x + c * y, z))

    def wrench_inward(self, k: int, wrench: Wrench) -> Wrench:
        """Express a wrench of body frame k in body frame k - 1, about its origin."""
        force = self.inward(k, wrench.force)
        moment = self.inward(k, wrench.moment)
        return Wrench(add(moment, cross(self.shift(k - 1), force)), force)

    def twist_outward(self, k: int, angular: Vector, linear: Vector) -> Twist:
        """Express a twist (angular, linear) of body frame k - 1 in body frame k."""
        linear = add(linear, cross(angular, self.shift(k - 1)))
        return self.outward(k, angular), self.outward(k, linear)

    def pseudo_inertia_inward(self, k: int, j: PseudoInertia) -> PseudoInertia:
        """Return X J X^T: a pseudo-inertia of body frame k, in body frame k - 1."""
        s, c = self._turns[k]
        # Rz: with 2c computed once per frame, the symmetric 2 x 2 block takes nine operations.
        turn = s * (j.xx - j.yy) + (c + c) * j.xy
        xx, yy, xy = j.xx - s * turn, j.yy + s * turn, c * turn - j.xy
        xz, yz = c * j.xz - s * j.yz, s * j.xz + c * j.yz
        # Rx swaps y and z.
        sign = _ALPHA[k - 1]
        xx, yy, zz, xy, xz, yz = xx, j.zz, yy, -sign * xz, sign * xy, -yz
        # The shift by p adds p h^T + h p^T.
        a, _, d = self.shift(k - 1)
        hx, hy, hz = self.inward(k, (j.hx, j.hy, j.hz))
        xz, yz = xz + d * hx, yz + d * hy
        ax, dz = a * hx, d * hz
        return PseudoInertia(xx + ax + ax, yy, zz + dz + dz, xy + a * hy, xz + a * hz, yz,
                             hx, hy, hz)

    def affine_inward(self, k: int, matrix: Affine) -> Affine:
        """Return X A X^T: a matrix of body frame k, in body frame k - 1."""
        s, c = self._turns[k]
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = matrix.block
        turn = s * (xx - yy) + c * (xy + yx)
        xx, yy, xy, yx = xx - s * turn, yy + s * turn, c * turn - yx, c * turn - xy
        xz, yz = c * xz - s * yz, s * xz + c * yz
        zx, zy = c * zx - s * zy, s * zx + c * zy
        sign = _ALPHA[k - 1]
        block: Matrix = ((xx, -sign * xz, sign * xy), (-sign * zx, zz, -zy), (sign * yx, -yz, yy))
        column = self.inward(k, matrix.column)
        a, _, d = self.shift(k - 1)
        block = tuple((x + a * h, y, z + d * h) for (x, y, z), h in zip(block, column))
        return Affine(block, column)


def add(x: Vector, y: Vector) -> Vector:
    """Return x + y, element by element."""
    return tuple(i + j for i, j in zip(x, y))


def cross(x: Vector, y: Vector) -> Vector:
    """Return x cross y."""
    return x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]


def dot(x: Vector, y: Vector) -> Scalar:
    """Return x . y."""
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


def apply(matrix: Matrix, v: Vector) -> Vector:
    """Return the product of a matrix and a vector."""
    return tuple(dot(row, v) for row in matrix)


def _swap(sign: int, v: Vector) -> Vector:
    """Rotate by sign * 90 degrees about x."""
    x, y, z = v
    return x, -sign * z, sign * y


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

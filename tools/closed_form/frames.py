"""
Body frames and the transformations between them, on scalars of any type.

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


class Frames:
    """
    Transformations between body frames at one configuration.

    Parameters
    ----------
    sine, cosine : sequence of 7 scalars
        Sine and cosine of theta.
    lengths : sequence of 6 pairs of scalars
        a and d [m] of links 1 to 6.

    """

    def __init__(self, sine: Scalars, cosine: Scalars, lengths: Sequence[Scalars]) -> None:
        self._turns = list(zip(sine, cosine))
        self._lengths = lengths

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

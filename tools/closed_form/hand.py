"""Pose and geometric Jacobian of the hand, on scalars of any type."""

from collections.abc import Sequence

from .frames import cross, Rows, Scalar, Scalars, Vector


class Hand:
    """
    Kinematic chain from the base frame to the hand.

    Joints 1 and 2, 3 and 4, 5 and 6 have perpendicular axes, so that each pair takes two rotations
    of two vectors instead of two matrix products.

    Parameters
    ----------
    sine, cosine : sequence of 7 scalars
        Sine and cosine of theta.
    pairs : sequence of 3 pairs of scalars
        a and d [m] of links 1, 3 and 5; those of links 2, 4 and 6 are zero.
    last : tuple of 4 scalars
        a and d [m], sine and cosine of alpha of link 7.
    mount : sequence of 3 rows of 4 scalars
        Pose of the paper's frame {0} in the base frame, translation in m.

    """

    def __init__(self, sine: Scalars, cosine: Scalars, pairs: Sequence[Scalars], last: Scalars,
                 mount: Sequence[Scalars]) -> None:
        x, y, z, origin = (tuple(column) for column in zip(*mount))
        self.joints: list[tuple[Vector, Vector]] = []  # axis, and a point on it
        for i, (a, d) in enumerate(pairs):
            self.joints.append((z, origin))
            # Eq. (2) with alpha = -90 degrees: x becomes u, and the next joint turns about v.
            u, v = _turned(sine[2 * i], cosine[2 * i], x, y)
            origin = _along(origin, a, u, d, z)
            self.joints.append((v, origin))
            # ... and with +90 degrees.
            x, z = _turned(-sine[2 * i + 1], cosine[2 * i + 1], u, z)
            y = v
        self.joints.append((z, origin))
        a, d, sa, ca = last
        u, v = _turned(sine[6], cosine[6], x, y)
        self.origin = _along(origin, a, u, d, z)
        v, z = _turned(sa, ca, v, z)
        self.axes = u, v, z

    def pose(self) -> Rows:
        """Return the homogeneous transform from the hand to the base frame."""
        return [list(row) for row in zip(*self.axes, self.origin)] + [[0, 0, 0, 1]]

    def jacobian(self) -> Rows:
        """Return the Jacobian: rows of the hand's linear, then of its angular velocity."""
        columns: list[tuple[Scalar, ...]] = []
        for axis, point in self.joints:
            arm = tuple(h - p for h, p in zip(self.origin, point))
            columns.append((*cross(axis, arm), *axis))
        return [list(row) for row in zip(*columns)]


def _turned(s: Scalar, c: Scalar, x: Vector, y: Vector) -> tuple[Vector, Vector]:
    """Return c x + s y and c y - s x."""
    return (tuple(c * i + s * j for i, j in zip(x, y)),
            tuple(c * j - s * i for i, j in zip(x, y)))


def _along(origin: Vector, a: Scalar, u: Vector, d: Scalar, z: Vector) -> Vector:
    return tuple(o + a * i + d * j for o, i, j in zip(origin, u, z))

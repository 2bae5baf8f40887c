"""Quantities of the closed form: inputs, shapes, units, formulas; kinematics of the hand."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from baxter_dynamics_ros.model.base_parameters import LENGTH_NAMES, NAMES, TILTED_NAMES

from .formulation import Formulation
from .frames import cross, Frames, N, PseudoInertia, Rows, Scalar, Scalars, Vector

# Inputs beside the state: base parameters, lengths, minus gravity, frames of hand and base.
UP_NAMES = ('up_x', 'up_y', 'up_z')
HAND_NAMES = ('d1', 'a7', 'd7', 'sin_alpha7', 'cos_alpha7')
MOUNT_NAMES = tuple(f'mount{row}{column}' for row in range(1, 4) for column in range(1, 5))
PARAMETERS = (*TILTED_NAMES, *LENGTH_NAMES, *UP_NAMES, *HAND_NAMES, *MOUNT_NAMES)
# Inputs that matter only if gravity is not along the axis of joint 1.
ONLY_TILTED = (*TILTED_NAMES[len(NAMES):], *UP_NAMES[:2])


class Output(NamedTuple):
    """One array that a quantity returns."""

    symbol: str
    shape: tuple[int, ...]
    unit: str
    text: str


class Quantity(NamedTuple):
    """A quantity of the closed form."""

    name: str  # as in BaxterArm
    inputs: tuple[str, ...]  # of 'qd', 'qdd', 'tau'; every quantity depends on q
    outputs: tuple[Output, ...]
    compute: Callable[..., Any]  # (arm, *inputs): an output, or a tuple of them


class Hand:
    """
    Kinematic chain from the base frame to the hand.

    Joints 1 and 2, 3 and 4, 5 and 6 have perpendicular axes, so that each pair takes two rotations
    of two vectors instead of two matrix products. Its arguments are sine and cosine of theta; a
    and d [m] of links 1, 3 and 5 (zero for links 2, 4 and 6); a, d, sine and cosine of alpha of
    link 7; and the rows of the pose of the paper's frame {0} in the base frame.
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


class Arm(Formulation):
    """Dynamics and hand at one configuration: sine and cosine of q, values of PARAMETERS."""

    def __init__(self, sine: Scalars, cosine: Scalars, parameters: dict[str, Scalar]) -> None:
        # theta = q, except for theta_2 = q_2 + pi/2.
        sine, cosine = list(sine), list(cosine)
        sine[1], cosine[1] = cosine[1], -sine[1]
        # Of link 1 only xx + yy matters; it is passed as xx.
        links = [PseudoInertia(xx=parameters['izz1'], hx=parameters['hx1'], hy=parameters['hy1'])]
        for k in range(2, N + 1):
            links.append(PseudoInertia(**{element: parameters[f'{element}{k}'] for element in
                                          ('xx', 'yy', 'xy', 'xz', 'yz', 'hx', 'hy')}))
        lengths = [[0, 0] for _ in range(N - 1)]
        for name in LENGTH_NAMES:
            lengths[int(name[1]) - 1]['ad'.index(name[0])] = parameters[name]
        super().__init__(Frames(sine, cosine, lengths), links,
                         tuple(parameters[name] for name in UP_NAMES))
        mount = [[parameters[f'mount{row}{column}'] for column in range(1, 5)]
                 for row in range(1, 4)]
        d1, *last = (parameters[name] for name in HAND_NAMES)
        self.hand = Hand(sine, cosine, [(lengths[0][0], d1), *lengths[2::2]], last, mount)


_M = Output('M', (N, N), 'kg m^2', 'mass matrix, eq. (6)')
_C = Output('C', (N, N), 'kg m^2/s', 'Coriolis matrix of the Christoffel symbols, eq. (7)')
_CQD = Output('Cqd', (N,), 'N m', 'C(q, qd) qd')
_G = Output('G', (N,), 'N m', 'gravity torques, eq. (8)')
_P = Output('momentum', (N,), 'N m s', 'generalised momentum M(q) qd')
_CTQD = Output('Ctqd', (N,), 'N m', 'C(q, qd)^T qd: dp/dt = tau + C^T qd - G')
_TAU = Output('tau', (N,), 'N m', 'M(q) qdd + C(q, qd) qd + G(q), eq. (5)')
_QDD = Output('qdd', (N,), 'rad/s^2', 'M(q)^-1 (tau - C(q, qd) qd - G(q))')
_H = Output('h', (N, N, N), 'kg m^2', 'Christoffel symbols h_ikm, C_ik = sum_m h_ikm qd_m')
_DQ = Output('dtau_dq', (N, N), 'N m/rad', 'derivative of tau by q; row i is tau_i')
_DQD = Output('dtau_dqd', (N, N), 'N m s/rad', 'derivative of tau by qd; row i is tau_i')
_Y = Output('Y', (N, len(TILTED_NAMES)), 'N m per base parameter',
            'regressor: tau = Y phi; the last two columns are zero where gravity is along the '
            'axis of joint 1')
_T = Output('T', (4, 4), '1, m', 'pose of the hand in the base frame')
_J = Output('J', (6, N), 'm, 1', 'Jacobian of the hand in the base frame: linear, then angular')

QUANTITIES = {quantity.name: quantity for quantity in (
    Quantity('mass_matrix', (), (_M,), Formulation.mass_matrix),
    Quantity('gravity', (), (_G,), Formulation.gravity),
    Quantity('coriolis_matrix', ('qd',), (_C,), Formulation.coriolis_matrix),
    Quantity('coriolis_torque', ('qd',), (_CQD,), Formulation.coriolis_torque),
    Quantity('terms', ('qd',), (_M, _C, _G),
             lambda arm, qd: (arm.mass_matrix(), arm.coriolis_matrix(qd), arm.gravity())),
    Quantity('torque_terms', ('qd',), (_M, _CQD, _G),
             lambda arm, qd: (arm.mass_matrix(), arm.coriolis_torque(qd), arm.gravity())),
    Quantity('momentum_terms', ('qd',), (_P, _CTQD, _G), Formulation.momentum_terms),
    Quantity('inverse_dynamics', ('qd', 'qdd'), (_TAU,), Formulation.inverse_dynamics),
    Quantity('forward_dynamics', ('qd', 'tau'), (_QDD,), Formulation.forward_dynamics),
    Quantity('christoffel_symbols', (), (_H,), Formulation.christoffel_symbols),
    Quantity('regressor', ('qd', 'qdd'), (_Y,), Formulation.regressor),
    Quantity('inverse_dynamics_gradient', ('qd', 'qdd'), (_DQ, _DQD),
             Formulation.inverse_dynamics_gradient),
    Quantity('forward_kinematics', (), (_T,), lambda arm: arm.hand.pose()),
    Quantity('jacobian', (), (_J,), lambda arm: arm.hand.jacobian()),
)}

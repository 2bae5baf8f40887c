"""Table of the quantities of the closed form: inputs, shapes, units, formulas."""

from collections.abc import Callable
from typing import Any, NamedTuple

from baxter_dynamics_ros.model.base_parameters import LENGTH_NAMES, NAMES, TILTED_NAMES

from .formulation import Formulation
from .frames import Frames, N, PseudoInertia, Scalar, Scalars
from .hand import Hand


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
    compute: Callable[..., Any]  # (formulation, *inputs): an output, or a tuple of them


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
             lambda f, qd: (f.mass_matrix(), f.coriolis_matrix(qd), f.gravity())),
    Quantity('torque_terms', ('qd',), (_M, _CQD, _G),
             lambda f, qd: (f.mass_matrix(), f.coriolis_torque(qd), f.gravity())),
    Quantity('momentum_terms', ('qd',), (_P, _CTQD, _G), Formulation.momentum_terms),
    Quantity('inverse_dynamics', ('qd', 'qdd'), (_TAU,), Formulation.inverse_dynamics),
    Quantity('forward_dynamics', ('qd', 'tau'), (_QDD,), Formulation.forward_dynamics),
    Quantity('christoffel_symbols', (), (_H,), Formulation.christoffel_symbols),
    Quantity('regressor', ('qd', 'qdd'), (_Y,), Formulation.regressor),
    Quantity('inverse_dynamics_gradient', ('qd', 'qdd'), (_DQ, _DQD),
             Formulation.inverse_dynamics_gradient),
    Quantity('forward_kinematics', (), (_T,), lambda f: f.hand.pose()),
    Quantity('jacobian', (), (_J,), lambda f: f.hand.jacobian()),
)}

# Further inputs in order: base parameters, lengths, minus gravity, frames of hand and base.
UP_NAMES = ('up_x', 'up_y', 'up_z')
HAND_NAMES = ('d1', 'a7', 'd7', 'sin_alpha7', 'cos_alpha7')
MOUNT_NAMES = tuple(f'mount{row}{column}' for row in range(1, 4) for column in range(1, 5))
PARAMETERS = (*TILTED_NAMES, *LENGTH_NAMES, *UP_NAMES, *HAND_NAMES, *MOUNT_NAMES)
# Inputs that matter only if gravity is not along the axis of joint 1.
ONLY_TILTED = (*TILTED_NAMES[len(NAMES):], *UP_NAMES[:2])


def formulate(sine: Scalars, cosine: Scalars, parameters: dict[str, Scalar]) -> Formulation:
    """
    Return the formulation at one configuration.

    Parameters
    ----------
    sine, cosine : sequence of 7 scalars
        Sine and cosine of q.
    parameters : dict
        Values by the names in :data:`PARAMETERS`.

    """
    # theta = q, except for theta_2 = q_2 + pi/2.
    sine, cosine = list(sine), list(cosine)
    sine[1], cosine[1] = cosine[1], -sine[1]
    links = [PseudoInertia(xx=parameters['izz1'], hx=parameters['hx1'], hy=parameters['hy1'])]
    for k in range(2, N + 1):
        links.append(PseudoInertia(**{element: parameters[f'{element}{k}'] for element in
                                      ('xx', 'yy', 'xy', 'xz', 'yz', 'hx', 'hy')}))
    lengths = [[0, 0] for _ in range(N - 1)]
    for name in LENGTH_NAMES:
        lengths[int(name[1]) - 1]['ad'.index(name[0])] = parameters[name]
    mount = [[parameters[name] for name in MOUNT_NAMES[4 * row:4 * row + 4]] for row in range(3)]
    d1, *last = (parameters[name] for name in HAND_NAMES)
    pairs = [(lengths[0][0], d1), *lengths[2::2]]
    hand = Hand(sine, cosine, pairs, last, mount)
    return Formulation(Frames(sine, cosine, lengths), links,
                       tuple(parameters[name] for name in UP_NAMES), hand)

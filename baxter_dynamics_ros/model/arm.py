"""BaxterArm: closed-form dynamics and kinematics of one Baxter arm."""

from typing import Any, TypeVar

import numpy as np

from . import paper_tables
from .arrays import Array, ArrayLike, finite, read_only
from .base_parameters import NAMES, TILTED_NAMES
from .closed_form import AUTO, choose_engine, functions, parameter_values
from .exceptions import ArgumentError
from .parameters import ArmParameters, paper_parameters, Payload

_T = TypeVar('_T')
_UPRIGHT = 1e-12  # relative gravity component across the axis of joint 1 that is rounding


class BaxterArm:
    r"""
    Rigid-body dynamics of a Baxter arm: tau = M(q) qdd + C(q, qd) qd + G(q), eq. (1).

    q, qd, qdd and tau have shape (..., 7) in the joint order s0, s1, e0, e1, w0, w1, w2; leading
    axes are a batch and broadcast against each other. Units are rad, rad/s, rad/s^2,
    N m, kg m^2. tau is positive in the direction of positive q.

    The right and the left arm have the same dynamics. Instances are immutable: create another one
    for another payload.

    Parameters
    ----------
    payload : Payload, optional
        Body fixed to the hand. None by default: link 7 of the paper is wrist and hand without a
        gripper.
    gravity : array_like (3,), optional
        Gravity vector in the base frame [m/s^2].
    mount : array_like (4, 4), optional
        Pose of the paper's frame {0} in the base frame. By default the base frame is frame {0};
        with ``mount('right')`` of :mod:`baxter_dynamics_ros` it is the robot's ``base``.
    parameters : ArmParameters, optional
        Link parameters; by default those of the paper, corrected.
    engine : str, optional
        'compiled' (C), 'python' (NumPy), or 'auto': the value of the environment variable
        BAXTER_DYNAMICS_ENGINE if set, else 'compiled' if the extension is installed. Results agree
        up to rounding.

    Attributes
    ----------
    engine : str
        'compiled' or 'python'.
    base_parameters : ndarray (43,) or (45,)
        phi of ``tau = Y phi``, in the order of ``model.base_parameters.TILTED_NAMES``. The last
        two, hx1 and hy1, exist only if gravity is not along the axis of joint 1. Read-only.
    closed_form_parameters : tuple of float
        Parameters of the closed form, in the order of ``model._closed_form.PARAMETERS``.

    Raises
    ------
    ArgumentError
        If an argument has the wrong shape or is not finite, mount is not a rigid transform, the
        kinematic structure differs from Baxter's, or the engine is unknown or not available.

    """

    def __init__(self, payload: Payload | None = None, gravity: ArrayLike = paper_tables.GRAVITY,
                 mount: ArrayLike | None = None, parameters: ArmParameters | None = None,
                 engine: str = AUTO) -> None:
        self.payload = _instance('payload', Payload() if payload is None else payload, Payload)
        self.parameters = _instance(
            'parameters', paper_parameters() if parameters is None else parameters, ArmParameters)
        # In the base frame [m/s^2].
        self.gravity_vector = read_only(finite('gravity', gravity, (3,)).copy())
        self.mount = _rigid_transform('mount', np.eye(4) if mount is None else mount)
        pseudo_inertia = self.parameters.pseudo_inertia.copy()
        pseudo_inertia[-1] += self.payload.pseudo_inertia
        gravity_0 = self.mount[:3, :3].T @ self.gravity_vector  # in frame {0}
        upright = bool(np.abs(gravity_0[:2]).max() <= _UPRIGHT * np.abs(gravity_0).max())
        if upright:  # remove the rounding errors of the mount
            gravity_0 = gravity_0 * [0.0, 0.0, 1.0]
        self._requested_engine = engine
        self.engine = choose_engine(engine)
        self.closed_form_parameters = parameter_values(self.parameters, pseudo_inertia, gravity_0,
                                                       self.mount)
        self._functions = functions(self.engine, self.closed_form_parameters,
                                    self.parameters.theta_offset)
        count = len(NAMES if upright else TILTED_NAMES)
        self.base_parameters = read_only(np.array(self.closed_form_parameters[:count]))

    def __reduce__(self) -> tuple[type['BaxterArm'], tuple[Any, ...]]:
        """Pickle and copy by constructor arguments."""
        return BaxterArm, (self.payload, self.gravity_vector, self.mount, self.parameters,
                           self._requested_engine)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """Return M(q), (..., 7, 7) [kg m^2]: symmetric, positive definite. Eq. (6)."""
        return self._functions['mass_matrix'](q)

    def coriolis_matrix(self, q: ArrayLike, qd: ArrayLike) -> Array:
        """
        Return C(q, qd), (..., 7, 7) [kg m^2/s], eq. (7).

        Built from the Christoffel symbols of M, so that dM/dt - 2 C is skew-symmetric.
        """
        return self._functions['coriolis_matrix'](q, qd)

    def coriolis_torque(self, q: ArrayLike, qd: ArrayLike) -> Array:
        """Return C(q, qd) qd, (..., 7) [N m], without forming C."""
        return self._functions['coriolis_torque'](q, qd)

    def gravity(self, q: ArrayLike) -> Array:
        """Return G(q), (..., 7) [N m]: the torques that hold the arm at rest. Eq. (8)."""
        return self._functions['gravity'](q)

    def terms(self, q: ArrayLike, qd: ArrayLike) -> tuple[Array, Array, Array]:
        """Return M(q) and C(q, qd), (..., 7, 7), and G(q), (..., 7), sharing common terms."""
        return self._functions['terms'](q, qd)

    def torque_terms(self, q: ArrayLike, qd: ArrayLike) -> tuple[Array, Array, Array]:
        """Return M(q), (..., 7, 7), C(q, qd) qd and G(q), (..., 7), without forming C."""
        return self._functions['torque_terms'](q, qd)

    def momentum_terms(self, q: ArrayLike, qd: ArrayLike) -> tuple[Array, Array, Array]:
        """
        Return p = M(q) qd [N m s], C(q, qd)^T qd and G(q) [N m], (..., 7), without forming M or C.

        They obey dp/dt = tau + C^T qd - G, the equation of a momentum observer.
        """
        return self._functions['momentum_terms'](q, qd)

    def inverse_dynamics(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return tau = M(q) qdd + C(q, qd) qd + G(q), (..., 7) [N m]. Eq. (5)."""
        return self._functions['inverse_dynamics'](q, qd, qdd)

    def forward_dynamics(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> Array:
        """Return qdd = M(q)^-1 (tau - C(q, qd) qd - G(q)), (..., 7) [rad/s^2]."""
        return self._functions['forward_dynamics'](q, qd, tau)

    def inverse_dynamics_gradient(self, q: ArrayLike, qd: ArrayLike,
                                  qdd: ArrayLike) -> tuple[Array, Array]:
        """
        Return d tau/dq [N m/rad] and d tau/dqd [N m s/rad], (..., 7, 7) each; row i is tau_i.

        The derivative with respect to qdd is M.
        """
        return self._functions['inverse_dynamics_gradient'](q, qd, qdd)

    def christoffel_symbols(self, q: ArrayLike) -> Array:
        """Return h_ikm of eq. (7), (..., 7, 7, 7) [kg m^2]: C_ik = sum over m of h_ikm qd_m."""
        return self._functions['christoffel_symbols'](q)

    def regressor(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return Y, (..., 7, 43) or (..., 7, 45): tau = Y phi, phi the ``base_parameters``."""
        result = self._functions['regressor'](q, qd, qdd)
        return result[..., :len(self.base_parameters)]

    def forward_kinematics(self, q: ArrayLike) -> Array:
        """Return the pose of the hand in the base frame, (..., 4, 4), translation in m."""
        return self._functions['forward_kinematics'](q)

    def jacobian(self, q: ArrayLike) -> Array:
        """
        Return the geometric Jacobian of the hand in the base frame, (..., 6, 7).

        Rows 0 to 2 give the velocity of the hand frame's origin [m/s], rows 3 to 5 the angular
        velocity of the hand [rad/s], both with base-frame axes.
        """
        return self._functions['jacobian'](q)


def with_gravity(arm: BaxterArm, gravity: ArrayLike) -> BaxterArm:
    """Return the same arm with another gravity vector (3,) in the base frame [m/s^2]."""
    return BaxterArm(arm.payload, gravity, arm.mount, arm.parameters, arm.engine)


def _instance(name: str, value: object, kind: type[_T]) -> _T:
    if not isinstance(value, kind):
        raise ArgumentError(name, f'expected {kind.__name__}, got {value!r}')
    return value


def _rigid_transform(name: str, value: ArrayLike) -> Array:
    pose = finite(name, value, (4, 4)).copy()
    rotation = pose[:3, :3]
    if (np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-6 or np.linalg.det(rotation) < 0
            or np.abs(pose[3] - [0.0, 0.0, 0.0, 1.0]).max() > 0):
        raise ArgumentError(name, 'expected a homogeneous transform: a rotation, a translation '
                            'and the last row 0 0 0 1')
    return read_only(pose)

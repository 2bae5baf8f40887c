"""BaxterArm: the closed-form dynamics of one Baxter arm, for people to use."""

from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any, cast, TypeVar

import numpy as np

from . import paper_tables
from .arrays import Array, ArrayLike
from .closed_form import AUTO, ClosedForm
from .composite import CompositeDynamics
from .exceptions import ArgumentError
from .joints import N_JOINTS
from .parameters import ArmParameters, paper_parameters, Payload
from .validation import finite, finite_batch

_T = TypeVar('_T')
_STATE = (N_JOINTS,)
_FLOAT = np.dtype(float)
_BLOCK = 4096  # states computed at a time, by what does not make its own blocks


class BaxterArm:
    r"""
    Rigid-body dynamics of a Baxter arm: tau = M(q) qdd + C(q, qd) qd + G(q), eq. (1).

    Joint order is s0, s1, e0, e1, w0, w1, w2, in which q, qd, qdd and tau have shape (..., 7);
    leading axes are a batch and broadcast against each other. Units are rad, rad/s, rad/s^2,
    N m, kg m^2. tau is positive in the direction of positive q.

    The right and the left arm have the same dynamics. To change a payload, make another instance.

    Parameters
    ----------
    payload : Payload, optional
        What the hand carries, in the hand frame. None by default: the paper's link 7 is wrist
        and hand without a gripper.
    gravity : array_like (3,), optional
        Gravity vector in the base frame [m/s^2].
    mount : array_like (4, 4), optional
        Pose of the paper's frame {0} in the base frame. Identity by default, which makes frame
        {0} the base frame; ``mount('right')`` of :mod:`baxter_dynamics_ros` makes it the robot's
        ``base``.
    parameters : ArmParameters, optional
        The links; by default those of the paper, corrected.
    engine : str, optional
        What computes the closed form: 'python' (with NumPy), 'numba', or, by default, 'auto':
        what the environment variable BAXTER_DYNAMICS_ENGINE says, or else numba where it is
        installed. The results are the same.

    Attributes
    ----------
    base_parameters : ndarray (43,) or (45,)
        phi of ``tau = Y phi``, in the order of ``model.base_parameters.TILTED_NAMES``: the last
        two, hx1 and hy1, only where gravity is not along the axis of joint 1.
    dynamics : ClosedForm
        The closed form in frame {0}, without validation.
    composite : CompositeDynamics
        The same by readable matrix equations, and the links' transforms.

    Raises
    ------
    ArgumentError
        If an argument has the wrong shape or is not finite, mount is not a rigid transform, the
        parameters are not those of an arm built like Baxter's, or the engine does not exist.

    """

    def __init__(self, payload: Payload | None = None, gravity: ArrayLike = paper_tables.GRAVITY,
                 mount: ArrayLike | None = None, parameters: ArmParameters | None = None,
                 engine: str = AUTO) -> None:
        self.payload = _instance('payload', payload, Payload, Payload)
        self.parameters = _instance('parameters', parameters, ArmParameters, paper_parameters)
        self.gravity_vector = finite('gravity', gravity, (3,)).copy()  # base frame [m/s^2]
        self.gravity_vector.flags.writeable = False
        self.mount = _rigid_transform('mount', np.eye(4) if mount is None else mount)
        pseudo_inertia = self.parameters.pseudo_inertia.copy()
        pseudo_inertia[-1] += self.payload.pseudo_inertia
        self._engine = engine
        in_frame_0 = self.mount[:3, :3].T @ self.gravity_vector
        self.dynamics = ClosedForm(self.parameters, pseudo_inertia, in_frame_0, engine)
        self.composite = CompositeDynamics(self.parameters, pseudo_inertia, in_frame_0)
        self.base_parameters = self.dynamics.base_parameters

    def __reduce__(self) -> tuple[type['BaxterArm'], tuple[Any, ...]]:
        """Pickle and copy what the arm was made of."""
        return BaxterArm, (self.payload, self.gravity_vector, self.mount, self.parameters,
                           self._engine)

    def mass_matrix(self, q: ArrayLike) -> Array:
        """Return M(q), (..., 7, 7) [kg m^2]: symmetric, positive definite. Eq. (6)."""
        return _apply(self.dynamics.mass_matrix, q=q)

    def coriolis_matrix(self, q: ArrayLike, qd: ArrayLike) -> Array:
        """
        Return C(q, qd), (..., 7, 7) [kg m^2/s], eq. (7).

        Built from the Christoffel symbols of M, so that dM/dt - 2 C is skew-symmetric.
        """
        return _apply(self.dynamics.coriolis_matrix, q=q, qd=qd)

    def coriolis_torque(self, q: ArrayLike, qd: ArrayLike) -> Array:
        """Return C(q, qd) qd, (..., 7) [N m], cheaper than by the matrix."""
        return _apply(self.dynamics.coriolis_torque, q=q, qd=qd)

    def gravity(self, q: ArrayLike) -> Array:
        """Return G(q), (..., 7) [N m]: the torques that hold the arm still. Eq. (8)."""
        return _apply(self.dynamics.gravity, q=q)

    def terms(self, q: ArrayLike, qd: ArrayLike) -> tuple[Array, Array, Array]:
        """
        Return M(q), C(q, qd) and G(q) together, cheaper than one by one.

        Returns
        -------
        tuple of ndarray
            Shapes (..., 7, 7), (..., 7, 7) and (..., 7).

        """
        return _apply(self.dynamics.terms, q=q, qd=qd)

    def torque_terms(self, q: ArrayLike, qd: ArrayLike) -> tuple[Array, Array, Array]:
        """
        Return M(q), C(q, qd) qd and G(q) together: what a controller needs, without the matrix C.

        Returns
        -------
        tuple of ndarray
            Shapes (..., 7, 7), (..., 7) and (..., 7).

        """
        return _apply(self.dynamics.torque_terms, q=q, qd=qd)

    def momentum_terms(self, q: ArrayLike, qd: ArrayLike) -> tuple[Array, Array, Array]:
        """
        Return p = M(q) qd, C(q, qd)^T qd and G(q) together, without forming M or C.

        They obey dp/dt = tau + C^T qd - G: what a momentum observer needs, which knows no qdd.

        Returns
        -------
        tuple of ndarray
            The generalised momentum [N m s] and two torques [N m], each (..., 7).

        """
        return _apply(self.dynamics.momentum_terms, q=q, qd=qd)

    def inverse_dynamics(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return tau = M(q) qdd + C(q, qd) qd + G(q), (..., 7) [N m]. Eq. (5)."""
        return _apply(self.dynamics.inverse_dynamics, q=q, qd=qd, qdd=qdd)

    def forward_dynamics(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> Array:
        """Return qdd = M(q)^-1 (tau - C(q, qd) qd - G(q)), (..., 7) [rad/s^2]."""
        return _apply(self.dynamics.forward_dynamics, q=q, qd=qd, tau=tau)

    def inverse_dynamics_gradient(self, q: ArrayLike, qd: ArrayLike,
                                  qdd: ArrayLike) -> tuple[Array, Array]:
        """
        Return the derivatives of tau by q and by qd; that by qdd is M.

        Returns
        -------
        tuple of ndarray
            d tau/dq [N m/rad] and d tau/dqd [N m s/rad], each (..., 7, 7); row i is tau_i.

        """
        return _apply(self.dynamics.inverse_dynamics_gradient, q=q, qd=qd, qdd=qdd)

    def christoffel_symbols(self, q: ArrayLike) -> Array:
        """Return h_ikm of eq. (7), (..., 7, 7, 7) [kg m^2]: C_ik = sum over m of h_ikm qd_m."""
        return _apply(self.dynamics.christoffel_symbols, q=q)

    def regressor(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return Y, (..., 7, 43) or (..., 7, 45): tau = Y phi, phi the ``base_parameters``."""
        return _apply(self.dynamics.regressor, q=q, qd=qd, qdd=qdd)

    def forward_kinematics(self, q: ArrayLike) -> Array:
        """Return the pose of the hand in the base frame, (..., 4, 4), translation in m."""
        return _blockwise(lambda q: self.mount @ self.composite.transforms(q)[..., -1, :, :],
                          _joints('q', q))

    def jacobian(self, q: ArrayLike) -> Array:
        """
        Return the geometric Jacobian of the hand in the base frame, (..., 6, 7).

        Rows 0 to 2 give the velocity of the hand frame's origin [m/s], rows 3 to 5 the angular
        velocity of the hand [rad/s], both with base-frame axes.
        """
        return _blockwise(self._jacobian, _joints('q', q))

    def _jacobian(self, q: Array) -> Array:
        transforms = self.composite.transforms(q)
        xi = self.composite.twists(transforms)
        hand = transforms[..., -1, :, 3]
        rotation = self.mount[:3, :3]
        linear = (xi @ hand[..., None, :, None])[..., :3, 0]  # U_7k [0 0 0 1]^T
        angular = np.stack([xi[..., 2, 1], xi[..., 0, 2], xi[..., 1, 0]], -1)
        return np.concatenate([rotation @ np.swapaxes(linear, -1, -2),
                               rotation @ np.swapaxes(angular, -1, -2)], axis=-2)


def _instance(name: str, value: object, kind: type[_T], default: Callable[[], _T]) -> _T:
    if value is None:
        return default()
    if not isinstance(value, kind):
        raise ArgumentError(name, f'expected a {kind.__name__}, got {value!r}')
    return value


def _joints(name: str, value: ArrayLike) -> Array:
    return finite_batch(name, value, N_JOINTS)


def _apply(function: Callable[..., _T], **arguments: ArrayLike) -> _T:
    """
    Call ``function``, which takes (7,) or (n, 7), on the named arguments (..., 7).

    They are validated, and their leading axes broadcast against each other.
    """
    values = arguments.values()
    if all(map(_is_state, values)):  # the common case, in a fraction of the time
        return function(*values)
    arrays = _broadcast(arguments)
    if arrays[0].ndim <= 2:
        return function(*arrays)
    shape = arrays[0].shape[:-1]
    result: Any = function(*(array.reshape(-1, N_JOINTS) for array in arrays))
    if isinstance(result, tuple):
        result = tuple(part.reshape(shape + part.shape[1:]) for part in result)
    else:
        result = result.reshape(shape + result.shape[1:])
    return cast(_T, result)


def _is_state(value: object) -> bool:
    """Return whether there is nothing to convert or to refuse."""
    return (type(value) is np.ndarray and value.shape == _STATE and value.dtype is _FLOAT
            and isfinite(value.dot(value)))


def _broadcast(arguments: dict[str, ArrayLike]) -> Sequence[Array]:
    """Validate the named arguments and broadcast their leading axes."""
    arrays = [_joints(name, value) for name, value in arguments.items()]
    try:
        return np.broadcast_arrays(*arrays)
    except ValueError:
        shapes = ', '.join(f'{name} {a.shape}' for name, a in zip(arguments, arrays))
        raise ArgumentError(', '.join(arguments),
                            f'leading axes do not broadcast: {shapes}') from None


def _blockwise(function: Callable[[Array], Array], q: Array) -> Array:
    """Call ``function`` on q (..., 7), in blocks where the batch is large."""
    rows = q.reshape(-1, N_JOINTS)
    if len(rows) <= _BLOCK:
        return function(q)
    parts = [function(rows[i:i + _BLOCK]) for i in range(0, len(rows), _BLOCK)]
    return np.concatenate(parts).reshape(q.shape[:-1] + parts[0].shape[1:])


def _rigid_transform(name: str, value: ArrayLike) -> Array:
    pose = finite(name, value, (4, 4)).copy()
    rotation = pose[:3, :3]
    if (np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-6 or np.linalg.det(rotation) < 0
            or np.abs(pose[3] - [0.0, 0.0, 0.0, 1.0]).max() > 0):
        raise ArgumentError(name, 'expected a homogeneous transform: a rotation, a translation '
                            'and the last row 0 0 0 1')
    pose.flags.writeable = False
    return pose

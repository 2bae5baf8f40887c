"""BaxterArm: the closed-form dynamics of one Baxter arm, for people to use."""

import numpy as np

from . import paper_tables
from .composite import CompositeDynamics
from .exceptions import ArgumentError
from .joints import N_JOINTS
from .parameters import ArmParameters
from .parameters import paper_parameters
from .parameters import Payload
from .validation import finite
from .validation import finite_batch

_BLOCK = 4096  # states computed at a time: keeps the memory of a large batch flat


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

    Attributes
    ----------
    dynamics : CompositeDynamics
        The engine, in frame {0} and without validation.

    Raises
    ------
    ArgumentError
        If an argument has the wrong shape or is not finite, or mount is not a rigid transform.

    """

    def __init__(self, payload: Payload = None, gravity=paper_tables.GRAVITY, mount=None,
                 parameters: ArmParameters = None):
        self.payload = _instance('payload', payload, Payload, Payload)
        self.parameters = _instance('parameters', parameters, ArmParameters, paper_parameters)
        self.gravity_vector = finite('gravity', gravity, (3,)).copy()  # base frame [m/s^2]
        self.gravity_vector.flags.writeable = False
        self.mount = _rigid_transform('mount', np.eye(4) if mount is None else mount)
        pseudo_inertia = self.parameters.pseudo_inertia.copy()
        pseudo_inertia[-1] += self.payload.pseudo_inertia
        self.dynamics = CompositeDynamics(
            self.parameters, pseudo_inertia, self.mount[:3, :3].T @ self.gravity_vector)

    def mass_matrix(self, q) -> np.ndarray:
        """Return M(q), (..., 7, 7) [kg m^2]: symmetric, positive definite. Eq. (6)."""
        return _blockwise(self.dynamics.mass_matrix, _joints('q', q))

    def coriolis_matrix(self, q, qd) -> np.ndarray:
        """
        Return C(q, qd), (..., 7, 7) [kg m^2/s], eq. (7).

        Built from the Christoffel symbols of M, so that dM/dt - 2 C is skew-symmetric.
        """
        return _blockwise(self.dynamics.coriolis_matrix, *_broadcast(q=q, qd=qd))

    def gravity(self, q) -> np.ndarray:
        """Return G(q), (..., 7) [N m]: the torques that hold the arm still. Eq. (8)."""
        return _blockwise(self.dynamics.gravity, _joints('q', q))

    def terms(self, q, qd) -> tuple:
        """
        Return M(q), C(q, qd) and G(q) together, cheaper than one by one.

        Returns
        -------
        tuple of ndarray
            Shapes (..., 7, 7), (..., 7, 7) and (..., 7).

        """
        return _blockwise(self.dynamics.terms, *_broadcast(q=q, qd=qd))

    def inverse_dynamics(self, q, qd, qdd) -> np.ndarray:
        """Return tau = M(q) qdd + C(q, qd) qd + G(q), (..., 7) [N m]. Eq. (5)."""
        return _blockwise(self.dynamics.inverse_dynamics, *_broadcast(q=q, qd=qd, qdd=qdd))

    def forward_dynamics(self, q, qd, tau) -> np.ndarray:
        """Return qdd = M(q)^-1 (tau - C(q, qd) qd - G(q)), (..., 7) [rad/s^2]."""
        return _blockwise(self._forward_dynamics, *_broadcast(q=q, qd=qd, tau=tau))

    def forward_kinematics(self, q) -> np.ndarray:
        """Return the pose of the hand in the base frame, (..., 4, 4), translation in m."""
        return _blockwise(lambda q: self.mount @ self.dynamics.transforms(q)[..., -1, :, :],
                          _joints('q', q))

    def jacobian(self, q) -> np.ndarray:
        """
        Return the geometric Jacobian of the hand in the base frame, (..., 6, 7).

        Rows 0 to 2 give the velocity of the hand frame's origin [m/s], rows 3 to 5 the angular
        velocity of the hand [rad/s], both with base-frame axes.
        """
        return _blockwise(self._jacobian, _joints('q', q))

    def _forward_dynamics(self, q, qd, tau):
        mass, coriolis, gravity = self.dynamics.terms(q, qd)
        bias = (coriolis @ qd[..., None])[..., 0] + gravity
        return np.linalg.solve(mass, (tau - bias)[..., None])[..., 0]

    def _jacobian(self, q):
        transforms = self.dynamics.transforms(q)
        xi = self.dynamics.twists(transforms)
        hand = transforms[..., -1, :, 3]
        rotation = self.mount[:3, :3]
        linear = (xi @ hand[..., None, :, None])[..., :3, 0]  # U_7k [0 0 0 1]^T
        angular = np.stack([xi[..., 2, 1], xi[..., 0, 2], xi[..., 1, 0]], -1)
        return np.concatenate([rotation @ np.swapaxes(linear, -1, -2),
                               rotation @ np.swapaxes(angular, -1, -2)], axis=-2)


def _instance(name: str, value, kind: type, default):
    if value is None:
        return default()
    if not isinstance(value, kind):
        raise ArgumentError(name, f'expected a {kind.__name__}, got {value!r}')
    return value


def _joints(name: str, value) -> np.ndarray:
    return finite_batch(name, value, N_JOINTS)


def _broadcast(**arguments) -> list:
    """Validate the named arguments and broadcast their leading axes."""
    arrays = [_joints(name, value) for name, value in arguments.items()]
    if all(array.ndim == 1 for array in arrays):
        return arrays
    try:
        return np.broadcast_arrays(*arrays)
    except ValueError:
        shapes = ', '.join(f'{name} {a.shape}' for name, a in zip(arguments, arrays))
        raise ArgumentError(', '.join(arguments),
                            f'leading axes do not broadcast: {shapes}') from None


def _blockwise(function, *arrays):
    """Call ``function`` on arrays (..., 7), in blocks where the batch is large."""
    shape = arrays[0].shape[:-1]
    n = arrays[0].size // N_JOINTS
    if n <= _BLOCK:
        return function(*arrays)
    rows = [array.reshape(n, N_JOINTS) for array in arrays]
    result = None
    for start in range(0, n, _BLOCK):
        part = function(*(row[start:start + _BLOCK] for row in rows))
        parts = part if isinstance(part, tuple) else (part,)
        if result is None:
            result = tuple(np.empty((n,) + p.shape[1:]) for p in parts)
        for whole, p in zip(result, parts):
            whole[start:start + _BLOCK] = p
    result = tuple(whole.reshape(shape + whole.shape[1:]) for whole in result)
    return result if isinstance(part, tuple) else result[0]


def _rigid_transform(name: str, value) -> np.ndarray:
    pose = finite(name, value, (4, 4)).copy()
    rotation = pose[:3, :3]
    if (np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-6 or np.linalg.det(rotation) < 0
            or np.abs(pose[3] - [0.0, 0.0, 0.0, 1.0]).max() > 0):
        raise ArgumentError(name, 'expected a homogeneous transform: a rotation, a translation '
                            'and the last row 0 0 0 1')
    pose.flags.writeable = False
    return pose

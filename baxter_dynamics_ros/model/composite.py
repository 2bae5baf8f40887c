r"""
Lagrange-Euler equations with composite pseudo-inertias: exact, vectorised, readable.

With the twist xi_k = 0T_{k-1} Q (0T_{k-1})^-1 of joint k, eqs. (9) and (10) become products,
U_jk = xi_k T_j, and the sums over links j need only be computed once, as *composite*
pseudo-inertias:

* S_l = T_l J_l T_l^T, the pseudo-inertia of link l in frame {0};
* H_j = sum_{l>=j} S_l, the pseudo-inertia of links j to 7 (sum in eq. (6));
* V_l = sum_{k<=l} xi_k qd_k, so that dT_l/dt = V_l T_l;
* B_j = sum_{l>=j} V_l S_l (sum in eq. (7));
* dxi_k/dt = V_k xi_k - xi_k V_k.

Then, with m = max(i, k) and <X, Y> = Tr(X Y^T),

* M_ik = <xi_k H_m, xi_i>                                   eq. (6)
* C_ik = <dxi_k/dt H_m + xi_k B_m, xi_i>                    eq. (7), the Christoffel matrix
* G_i = -g . (xi_i H_i)[:, 4]                               eq. (8)
* tau_i = <sum_{l>=i} A_l S_l, xi_i>                        eq. (5)

  = sum_{l>=i} Tr[(xi_i T_l)^T (A_l T_l) J_l]             linear in the pseudo-inertias

where A_l T_l = d^2 T_l/dt^2 - gravity. With u_k = xi_k qd_k, eq. (10) makes it
A_l = sum_{k<=l} (xi_k qdd_k + (2 V_k - u_k) u_k) - gravity.

No approximation is involved: tests compare with :mod:`.lagrange_euler` at 1e-12.
"""

import numpy as np

from .arrays import Array
from .joints import N_JOINTS
from .parameters import ArmParameters

# Matrix that maps z to the flattened 4 x 4 matrix [[skew(z), 0], [0, 0]].
_SKEW = np.zeros((3, 16))
_SKEW[0, [9, 6]] = 1.0, -1.0
_SKEW[1, [2, 8]] = 1.0, -1.0
_SKEW[2, [4, 1]] = 1.0, -1.0

_LOWER = np.tri(N_JOINTS)  # sums from the base outward
_UPPER = _LOWER.T.copy()  # sums from the hand inward
_IS_LOWER = _LOWER.astype(bool)
_IDENTITY = np.eye(4)


class CompositeDynamics:
    """
    Dynamics of an arm in frame {0} for one set of parameters.

    Inputs are float arrays of shape (..., 7), already validated; leading axes are a batch.

    Parameters
    ----------
    parameters : ArmParameters
        The links.
    pseudo_inertia : ndarray (7, 4, 4)
        J of eq. (12): that of ``parameters``, with any payload added to the last link.
    gravity : ndarray (3,)
        Gravity vector in frame {0} [m/s^2].

    """

    def __init__(self, parameters: ArmParameters, pseudo_inertia: Array, gravity: Array) -> None:
        self._offset = parameters.theta_offset
        self._pseudo_inertia = pseudo_inertia
        self._minus_g = -np.append(gravity, 0.0)
        self._base_acceleration = np.zeros((4, 4))  # equivalent to gravity
        self._base_acceleration[:, 3] = self._minus_g
        # Eq. (2) is affine in (cos theta, sin theta): constant, cosine and sine parts.
        a, d = parameters.a, parameters.d
        sa, ca = np.sin(parameters.alpha), np.cos(parameters.alpha)
        constant, cosine, sine = np.zeros((3, N_JOINTS, 4, 4))
        constant[:, 2, 1], constant[:, 2, 2], constant[:, 2, 3] = sa, ca, d
        constant[:, 3, 3] = 1.0
        cosine[:, 0, 0], cosine[:, 1, 1], cosine[:, 1, 2], cosine[:, 0, 3] = 1.0, ca, -sa, a
        sine[:, 1, 0], sine[:, 0, 1], sine[:, 0, 2], sine[:, 1, 3] = 1.0, -ca, sa, a
        self._constant, self._cosine, self._sine = constant, cosine, sine

    def transforms(self, q: Array) -> Array:
        """Return 0T_0 = 1, 0T_1, ... 0T_7, (..., 8, 4, 4)."""
        theta = (q + self._offset)[..., None, None]
        result = np.empty(q.shape[:-1] + (N_JOINTS + 1, 4, 4))
        result[..., 0, :, :] = _IDENTITY
        links = result[..., 1:, :, :]
        np.multiply(np.cos(theta), self._cosine, out=links)
        links += np.sin(theta) * self._sine
        links += self._constant
        for step in (1, 2, 4):  # all prefix products in three batched products
            links[..., step:, :, :] = links[..., :-step, :, :] @ links[..., step:, :, :]
        return result

    def twists(self, transforms: Array) -> Array:
        """Return the joint twists xi_k = [[skew(z), p x z], [0, 0]], (..., 7, 4, 4)."""
        frames = transforms[..., :-1, :, :]  # frame {k-1} holds the axis of joint k
        result = (frames[..., :3, 2] @ _SKEW).reshape(frames.shape)
        result[..., 3:] = -(result @ frames[..., 3:])
        return result

    def mass_matrix(self, q: Array) -> Array:
        """Return M(q), (..., 7, 7) [kg m^2], eq. (6)."""
        xi, s = self._geometry(q)
        return _mass_matrix(xi, xi @ _sum(_UPPER, s))

    def gravity(self, q: Array) -> Array:
        """Return G(q), (..., 7) [N m], eq. (8)."""
        t = self.transforms(q)
        first_moments = t[..., 1:, :, :] @ self._pseudo_inertia[:, :, 3:]
        moved = self.twists(t) @ (_UPPER @ first_moments[..., 0])[..., None]
        return moved[..., 0] @ self._minus_g

    def coriolis_matrix(self, q: Array, qd: Array) -> Array:
        """Return C(q, qd), (..., 7, 7) [kg m^2/s], eq. (7)."""
        return self.terms(q, qd)[1]

    def terms(self, q: Array, qd: Array) -> tuple[Array, Array, Array]:
        """Return M(q), C(q, qd) and G(q) together, eqs. (6) to (8)."""
        xi, s = self._geometry(q)
        v = _sum(_LOWER, xi * qd[..., None, None])
        xi_dot = v @ xi - xi @ v
        h = _sum(_UPPER, s)
        b = _sum(_UPPER, v @ s)
        xi_h = xi @ h
        below = _inner(xi_h, xi_dot) + _inner(xi @ b.swapaxes(-1, -2), xi)  # m = i
        above = _inner(xi, xi_dot @ h + xi @ b)  # m = k
        coriolis = np.where(_IS_LOWER, below, above)
        return _mass_matrix(xi, xi_h), coriolis, xi_h[..., 3] @ self._minus_g

    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return tau, (..., 7) [N m], eq. (5), without forming M or C."""
        xi, s = self._geometry(q)
        return (_sum(_UPPER, self._acceleration(xi, qd, qdd) @ s) * xi).sum((-1, -2))

    def regressor(self, q: Array, qd: Array, qdd: Array) -> Array:
        """
        Return Y, (..., 7, 7, 4, 4): tau_i = sum over l of Tr(Y_il J_l), eq. (5).

        Y_il is the derivative of tau_i with respect to J_l, which does not depend on the inertial
        parameters; it is zero for i > l.
        """
        t = self.transforms(q)
        xi, links = self.twists(t), t[..., 1:, :, :]
        moved = (self._acceleration(xi, qd, qdd) @ links)[..., None, :, :, :]
        result = (xi[..., None, :, :] @ links[..., None, :, :, :]).swapaxes(-1, -2) @ moved
        return result * _UPPER[:, :, None, None]

    def _acceleration(self, xi: Array, qd: Array, qdd: Array) -> Array:
        """Return A_1 ... A_7, (..., 7, 4, 4)."""
        u = xi * qd[..., None, None]
        v = _sum(_LOWER, u)
        return _sum(_LOWER, xi * qdd[..., None, None] + (v + v - u) @ u) + self._base_acceleration

    def _geometry(self, q: Array) -> tuple[Array, Array]:
        """Return the twists xi and the links' pseudo-inertias S in frame {0}."""
        t = self.transforms(q)
        links = t[..., 1:, :, :]
        return self.twists(t), links @ self._pseudo_inertia @ links.swapaxes(-1, -2)


def _sum(links: Array, x: Array) -> Array:
    """Return sum_l links[j, l] x_l, (..., 7, 4, 4)."""
    return _product(links, x.reshape(x.shape[:-2] + (16,))).reshape(x.shape)


def _inner(x: Array, y: Array) -> Array:
    """Return <x_i, y_k> for all i, k: (..., 7, 7)."""
    flat = x.shape[:-2] + (16,)
    return _product(x.reshape(flat), y.reshape(flat).swapaxes(-1, -2))


def _product(x: Array, y: Array) -> Array:
    """Return x @ y; ``dot`` is twice as fast for a single pair of matrices."""
    return x.dot(y) if y.ndim == 2 else x @ y


def _mass_matrix(xi: Array, xi_h: Array) -> Array:
    """Return M from its lower triangle <xi_i H_i, xi_k>, k <= i."""
    lower = _inner(xi_h, xi)
    return np.where(_IS_LOWER, lower, lower.swapaxes(-1, -2))

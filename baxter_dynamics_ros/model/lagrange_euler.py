"""
Lagrange-Euler formulation of the paper, equation by equation: the specification of the model.

The functions implement eqs. (2) and (5) to (11) term by term, in the paper's notation and frame
{0}, with indices that start at 0. They are too slow for streams: :mod:`.closed_form`, the engine
of :class:`~baxter_dynamics_ros.BaxterArm`, computes the same in far fewer operations.

``p`` is an :class:`~baxter_dynamics_ros.model.parameters.ArmParameters`, ``q``, ``qd`` and ``qdd``
have shape (..., 7) in rad, rad/s, rad/s^2, and ``g`` is the gravity vector (3,) in frame {0},
``(0, 0, -9.81)`` in the paper [m/s^2].

One misprint is corrected: eq. (8) prints U_ij instead of U_ji.
"""

import numpy as np

from .arrays import Array, ArrayLike
from .joints import N_JOINTS
from .parameters import ArmParameters

# Eq. (11): derivative of a rotation about z, for a revolute joint.
Q = np.array([[0.0, -1.0, 0.0, 0.0],
              [1.0, 0.0, 0.0, 0.0],
              [0.0, 0.0, 0.0, 0.0],
              [0.0, 0.0, 0.0, 0.0]])


def link_transform(p: ArmParameters, i: int, q: ArrayLike) -> Array:
    """Return ``(i-1)T_i`` of eq. (2), (..., 4, 4), from frame i to the previous frame."""
    theta = np.asarray(q)[..., i] + p.theta_offset[i]
    st, ct = np.sin(theta), np.cos(theta)
    sa, ca = np.sin(p.alpha[i]), np.cos(p.alpha[i])
    result = np.zeros(theta.shape + (4, 4))
    result[..., 0, 0], result[..., 0, 1], result[..., 0, 2] = ct, -ca * st, sa * st
    result[..., 1, 0], result[..., 1, 1], result[..., 1, 2] = st, ca * ct, -sa * ct
    result[..., 0, 3], result[..., 1, 3] = p.a[i] * ct, p.a[i] * st
    result[..., 2, 1], result[..., 2, 2], result[..., 2, 3] = sa, ca, p.d[i]
    result[..., 3, 3] = 1.0
    return result


def transform(p: ArmParameters, i: int, j: int, q: ArrayLike) -> Array:
    """Return ``iT_j``, i <= j, (..., 4, 4), the product of link transforms; frame 0 is {0}."""
    result = np.broadcast_to(np.eye(4), np.shape(q)[:-1] + (4, 4))
    for k in range(i, j):
        result = result @ link_transform(p, k, q)
    return result


def u(p: ArmParameters, i: int, j: int, q: ArrayLike) -> Array:
    """Return U_ij = d(0T_i)/dq_j of eq. (9), (..., 4, 4)."""
    if j > i:
        return np.zeros(np.shape(q)[:-1] + (4, 4))
    return transform(p, 0, j, q) @ Q @ transform(p, j, i + 1, q)


def u_jk(p: ArmParameters, i: int, j: int, k: int, q: ArrayLike) -> Array:
    """Return U_ijk = dU_ij/dq_k of eq. (10), (..., 4, 4)."""
    if i < j or i < k:
        return np.zeros(np.shape(q)[:-1] + (4, 4))
    first, second = min(j, k), max(j, k)
    return (transform(p, 0, first, q) @ Q @ transform(p, first, second, q) @ Q
            @ transform(p, second, i + 1, q))


def mass_matrix(p: ArmParameters, q: ArrayLike) -> Array:
    """Return M(q) of eq. (6), (..., 7, 7) [kg m^2]."""
    n = N_JOINTS
    result = np.zeros(np.shape(q)[:-1] + (n, n))
    for i in range(n):
        for k in range(n):
            for j in range(max(i, k), n):
                result[..., i, k] += _trace(u(p, j, k, q), p.pseudo_inertia[j], u(p, j, i, q))
    return result


def christoffel(p: ArmParameters, q: ArrayLike) -> Array:
    """
    Return h_ikm of eq. (7), (..., 7, 7, 7) [kg m^2]: the Christoffel symbols of M(q).

    They are symmetric in k and m.
    """
    n = N_JOINTS
    result = np.zeros(np.shape(q)[:-1] + (n, n, n))
    for i in range(n):
        for k in range(n):
            for m in range(k + 1):
                for j in range(max(i, k, m), n):
                    result[..., i, k, m] += _trace(
                        u_jk(p, j, k, m, q), p.pseudo_inertia[j], u(p, j, i, q))
                result[..., i, m, k] = result[..., i, k, m]
    return result


def coriolis_matrix(p: ArmParameters, q: ArrayLike, qd: Array) -> Array:
    """Return C(q, qd), C_ik = sum_m h_ikm qd_m, (..., 7, 7) [kg m^2/s]; C qd is eq. (7)."""
    return np.einsum('...ikm,...m->...ik', christoffel(p, q), qd)


def gravity(p: ArmParameters, q: ArrayLike, g: ArrayLike) -> Array:
    """Return G(q) of eq. (8), (..., 7) [N m]."""
    n = N_JOINTS
    result = np.zeros(np.shape(q)[:-1] + (n,))
    g_row = np.append(g, 0.0)
    for i in range(n):
        for j in range(i, n):
            moment = p.pseudo_inertia[j][:, 3]  # m_j r_j, homogeneous
            result[..., i] -= (u(p, j, i, q) @ moment) @ g_row
    return result


def inverse_dynamics(p: ArmParameters, q: ArrayLike, qd: Array, qdd: Array, g: ArrayLike) -> Array:
    """Return tau of eq. (5), (..., 7) [N m]."""
    inertial = np.einsum('...ik,...k->...i', mass_matrix(p, q), qdd)
    coriolis = np.einsum('...ik,...k->...i', coriolis_matrix(p, q, qd), qd)
    return inertial + coriolis + gravity(p, q, g)


def _trace(x: Array, pseudo_inertia: Array, y: Array) -> Array:
    """Return Tr(x J y^T), (...)."""
    return np.einsum('...ab,bc,...ac->...', x, pseudo_inertia, y)

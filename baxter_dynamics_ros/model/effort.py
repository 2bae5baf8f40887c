r"""
Effort model: difference between measured effort and joint torque tau.

    effort = (I + crosstalk) (tau + spring(q_s1) + friction + bias + stiffness q
                              + added_inertia qdd)

Two strong springs act on s1 in parallel with the motor and help carry the arm, so the measured
effort does not contain their share of tau_s1. Simulators have no springs, see
:meth:`EffortModel.rigid`.
"""

from dataclasses import dataclass
from functools import cached_property
import math

import numpy as np

from .arrays import Array, Bools, read_only
from .exceptions import ArgumentError
from .joints import JOINTS, N_JOINTS, S1
from .setting import Group, setting

# Spring at s1: coefficients of 1, sin q, cos q, sin 2q, cos 2q [N m]. Fitted to recordings of two
# robots by `baxter_dynamics calibrate` (docs/calibrate.md has the command); a hysteresis of 1 to
# 1.5 N m is not included. The sum is well determined, the individual coefficients are not.
SPRING_COEFFICIENTS = read_only(np.array([-5.7466, -8.6679, 38.3573, 9.3798, 2.2237]))
# Angles of s1 in those recordings [rad]. Outside, the spring torque at the limit is used.
SPRING_RANGE = read_only(np.array([-1.9, 1.0]))

# Expected standard deviations within which 95 % of the residuals of free motion lie.
BAND = 1.96

# Share of the effort of joint j (column) in the measured effort of joint i (row): e1 measures a
# part of the effort of e0 on all robots tried.
CROSSTALK = np.zeros((N_JOINTS, N_JOINTS))
CROSSTALK[JOINTS.index('e1'), JOINTS.index('e0')] = -0.037

_ZEROS = np.zeros(N_JOINTS)


@dataclass(frozen=True, eq=False)
class EffortModel(Group, prefix='effort_model.'):
    """
    Difference between measured effort and joint torque; joint order s0 ... w2.

    Friction is ``coulomb tanh(qd / coulomb_velocity) + viscous qd + dahl z``, with Dahl's state z
    of :class:`Presliding`. The absolute values of a row of crosstalk sum to less than 1.

    Methods take validated float arrays (..., 7); leading axes are a batch. Arrays are stored as
    read-only copies. ArgumentError is raised if a value has the wrong shape, is out of range or
    not finite, or if values contradict each other.
    """

    spring_coefficients: Array = setting(
        SPRING_COEFFICIENTS, 'Spring torque at s1: coefficients of 1, sin q, cos q, sin 2q, '
        'cos 2q.', 'N m', -200.0, 200.0)
    spring_range: Array = setting(
        SPRING_RANGE, 'Range of s1 in which the spring model is valid. Outside, the spring torque '
        'at the limit is used.', 'rad', -3.2, 3.2)
    coulomb: Array = setting(_ZEROS, 'Coulomb friction per joint.', 'N m', 0.0, 50.0)
    coulomb_velocity: float = setting(
        0.05, 'Velocity over which Coulomb friction changes sign.', 'rad/s', 1e-3, 1.0)
    viscous: Array = setting(_ZEROS, 'Viscous friction per joint.', 'N m s/rad', 0.0, 50.0)
    dahl: Array = setting(_ZEROS, 'Pre-sliding (Dahl) friction per joint.', 'N m', 0.0, 50.0)
    dahl_length: float = setting(
        0.02, 'Displacement over which Dahl friction reverses.', 'rad', 1e-4, 1.0)
    bias: Array = setting(_ZEROS, 'Offset of measured effort per joint.', 'N m', -50.0, 50.0)
    stiffness: Array = setting(_ZEROS, 'Cable stiffness per joint.', 'N m/rad', -50.0, 50.0)
    added_inertia: Array = setting(
        _ZEROS, 'Inertia per joint in addition to that of the links.', 'kg m^2', -5.0, 5.0)
    crosstalk: Array = setting(
        CROSSTALK, 'Share of the effort of each joint in the measured effort of another: 7 x 7, '
        'row by row, row i for the measured effort of joint i; the diagonal is zero.', '',
        -0.5, 0.5)
    # Of a robot that is not calibrated, from recordings of five arms of three laboratories; s1 of
    # one of them has an offset of 31 N m.
    deviation: Array = setting(
        np.array([0.6, 17.0, 1.4, 1.7, 0.2, 0.5, 0.25]),
        'Expected standard deviation of the residual per joint at rest.', 'N m', 0.0, 100.0)
    deviation_velocity: Array = setting(
        np.array([1.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0]),
        'Expected standard deviation of the residual per joint and velocity.', 'N m s/rad',
        0.0, 100.0)
    deviation_acceleration: Array = setting(
        np.array([0.4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        'Expected standard deviation of the residual per joint and acceleration.',
        'N m s^2/rad', 0.0, 100.0)

    def __post_init__(self) -> None:
        """Validate each value, and values together."""
        super().__post_init__()
        if self.spring_range[0] >= self.spring_range[1]:
            raise ArgumentError('effort_model.spring_range',
                                f'expected lower < upper, got {self.spring_range.tolist()}')
        if (self.crosstalk.diagonal().any()
                or np.abs(self.crosstalk).sum(axis=1).max() >= 1.0):
            raise ArgumentError(
                'effort_model.crosstalk', 'expected a zero diagonal, and rows whose absolute '
                f'values sum to less than 1, got {self.crosstalk.tolist()}')

    @classmethod
    def rigid(cls) -> 'EffortModel':
        """Return the model of a simulator: effort = tau."""
        return cls(spring_coefficients=np.zeros(5), crosstalk=np.zeros((N_JOINTS, N_JOINTS)),
                   deviation=_ZEROS, deviation_velocity=_ZEROS, deviation_acceleration=_ZEROS)

    @cached_property
    def has_spring(self) -> bool:
        """Whether any spring coefficient is not zero."""
        return bool(self.spring_coefficients.any())

    @cached_property
    def _spring(self) -> tuple[float, ...]:
        """Coefficients and range of the spring as plain numbers."""
        return (*self.spring_coefficients.tolist(), *self.spring_range.tolist())

    @cached_property
    def has_friction(self) -> bool:
        """Whether any joint has friction of any kind."""
        return bool((self.coulomb + self.viscous + self.dahl).any())

    @property
    def presliding_length(self) -> 'float | None':
        """Length for :class:`Presliding` [rad]; None without Dahl friction."""
        return self.dahl_length if self.dahl.any() else None

    def spring(self, q: Array) -> Array:
        """Return the spring effort (..., 7) [N m], zero except at s1, for q (..., 7) [rad]."""
        c0, c1, c2, c3, c4, lower, upper = self._spring
        sin: Array | float
        cos: Array | float
        if q.ndim == 1:  # plain numbers are several times faster
            s1 = min(max(q.item(S1), lower), upper)
            sin, cos = math.sin(s1), math.cos(s1)
        else:
            angles = np.clip(q[..., S1], lower, upper)
            sin, cos = np.sin(angles), np.cos(angles)
        result = np.zeros(q.shape)
        # sin 2q = 2 sin q cos q, cos 2q = 1 - 2 sin^2 q
        result[..., S1] = (c0 + c4) + c1 * sin + c2 * cos + 2.0 * sin * (c3 * cos - c4 * sin)
        return result

    def spring_is_held(self, q: Array) -> Bools | bool:
        """Return whether s1 is outside the range of a spring, (...) bool, for q (..., 7) [rad]."""
        *_, lower, upper = self._spring
        s1 = q.item(S1) if q.ndim == 1 else q[..., S1]  # plain numbers are faster
        return self.has_spring & ((s1 < lower) | (s1 > upper))

    def friction(self, qd: Array, presliding: Array | None = None) -> Array:
        """
        Return Coulomb, viscous and Dahl friction, (..., 7) [N m], for qd (..., 7) [rad/s].

        ``presliding`` is Dahl's state z, by default the steady one, tanh(qd / coulomb_velocity).
        """
        if not self.has_friction:
            return np.zeros(qd.shape)
        sliding = np.tanh(qd / self.coulomb_velocity)
        z = sliding if presliding is None else presliding
        return self.coulomb * sliding + self.viscous * qd + self.dahl * z

    def other(self, q: Array, qdd: Array | float) -> Array:
        """Return bias, cable and added-inertia effort (..., 7) [N m] for q, qdd (..., 7)."""
        return self.bias + self.stiffness * q + self.added_inertia * qdd

    def effort(self, tau: Array, q: Array, qd: Array, qdd: Array,
               presliding: Array | None = None) -> Array:
        """Return the predicted measured effort for joint torques tau, both (..., 7) [N m]."""
        return self.coupled(tau + self.spring(q) + self.other(q, qdd)
                            + self.friction(qd, presliding))

    def torque(self, measured: Array, q: Array, qd: Array,
               presliding: Array | None = None) -> Array:
        """
        Return the joint torques, added inertia included, for measured effort, (..., 7) [N m].

        The inverse of :meth:`effort`: ``tau + added_inertia qdd``.
        """
        return (measured @ self._inverse - self.spring(q) - self.other(q, 0.0)
                - self.friction(qd, presliding))

    def coupled(self, effort: Array) -> Array:
        """Return effort (..., 7) with the crosstalk between the joints [N m]."""
        return effort + effort @ self.crosstalk.T

    @cached_property
    def _inverse(self) -> Array:
        """Inverse of (I + crosstalk)^T, (7, 7)."""
        return np.linalg.inv(np.eye(N_JOINTS) + self.crosstalk.T).astype(float)

    def deviation_at(self, qd: Array, qdd: Array) -> Array:
        """Return the expected standard deviation of the residual at qd, qdd, (..., 7) [N m]."""
        return np.sqrt(self.deviation ** 2 + (self.deviation_velocity * qd) ** 2
                       + (self.deviation_acceleration * qdd) ** 2)


class Presliding:
    """
    Dahl's model of the transition from sticking to sliding; friction is ``dahl * z``.

    A joint that reverses does not feel the full friction of the new direction at once: the contact
    first deflects over a few hundredths of a radian. The state z in [-1, 1] follows
    ``dz/dq = (1 - z sign(qd)) / length``, which depends on angles, not on time. For a step in one
    direction the solution is exact: z approaches the direction's sign by
    ``exp(-|change of q| / length)``. On Baxter it explains the hysteresis at s1.
    """

    def __init__(self, length: float | None) -> None:
        self.length = length  # angle over which friction reverses [rad]; None: not followed
        self.reset()

    def change_length(self, length: float | None) -> None:
        """Change the length; the state stays if it was followed."""
        if self.length is None:
            self.reset()
        self.length = length

    def reset(self) -> None:
        """Forget the history: no friction until the joints move."""
        self._q: Array | None = None
        self.z: Array = np.zeros(N_JOINTS)  # -1 or 1 while a joint slides, 0 while unknown

    def update(self, q: Array) -> Array:
        """Advance to q (7,) [rad] and return z."""
        if self.length is None:
            return self.z
        if self._q is not None:
            step = q - self._q
            direction = np.sign(step)
            self.z = direction + (self.z - direction) * np.exp(np.abs(step) / -self.length)
        self._q = q
        return self.z

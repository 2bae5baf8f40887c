r"""
Effort model: difference between measured effort and joint torque tau.

    effort = tau + spring(q_s1) + friction + bias + stiffness q + added_inertia qdd

Two strong springs act on s1 in parallel with the motor and help carry the arm, so the measured
effort does not contain their share of tau_s1. Simulators have no springs, see
:meth:`EffortModel.rigid`.
"""

from dataclasses import dataclass, field
import math
from typing import TYPE_CHECKING

import numpy as np

from .arrays import Array, ArrayLike, Bools
from .exceptions import ArgumentError
from .joints import N_JOINTS, S1
from .validation import finite, number

# Spring at s1: coefficients of 1, sin q, cos q, sin 2q, cos 2q [N m]. Fitted to recordings of two
# robots by `baxter_dynamics calibrate` (docs/calibrate.md has the command); a hysteresis of 1 to
# 1.5 N m is not included. The sum is well determined, the individual coefficients are not.
SPRING_COEFFICIENTS = (-5.7466, -8.6679, 38.3573, 9.3798, 2.2237)
# Angles of s1 in those recordings [rad]. Outside, the spring torque at the limit is used.
SPRING_RANGE = (-1.9, 1.0)

# Velocity scale of the smoothed sign in Coulomb friction [rad/s].
COULOMB_VELOCITY = 0.05

# Angle over which Dahl friction reverses [rad].
DAHL_LENGTH = 0.02

_PER_JOINT = ('coulomb', 'viscous', 'dahl', 'bias', 'stiffness', 'added_inertia')
_NOT_NEGATIVE = ('coulomb', 'viscous', 'dahl')


def _zeros() -> Array:
    return np.zeros(N_JOINTS)


@dataclass(frozen=True, eq=False)
class EffortModel:
    """
    Difference between measured effort and joint torque; joint order s0 ... w2.

    Methods take validated float arrays (..., 7); leading axes are a batch.

    Attributes
    ----------
    spring_coefficients : array_like (5,)
        Spring at s1 over 1, sin q, cos q, sin 2q, cos 2q [N m].
    spring_range : array_like (2,)
        Angles of s1 for which they are valid [rad]; outside, the value at the limit is used.
    coulomb : array_like (7,)
        Coulomb friction [N m], not negative: ``coulomb * tanh(qd / coulomb_velocity)``.
    viscous : array_like (7,)
        Viscous friction [N m s/rad], not negative: ``viscous * qd``.
    dahl : array_like (7,)
        Dahl friction [N m], not negative: ``dahl * z``, z from :class:`.presliding.Presliding`.
    bias : array_like (7,)
        Constant offset of the measured effort [N m].
    stiffness : array_like (7,)
        Cable stiffness [N m/rad], of either sign: ``stiffness * q``.
    added_inertia : array_like (7,)
        Apparent inertia in addition to the links' [kg m^2], of either sign:
        ``added_inertia * qdd``.
    coulomb_velocity : float
        Velocity scale of the smoothed sign [rad/s].
    dahl_length : float
        Angle over which Dahl friction reverses [rad].
    has_spring, has_friction, has_dahl, has_added_inertia : bool
        Whether any coefficient of the term is not zero; friction includes Dahl friction.

    Raises
    ------
    ArgumentError
        If a value has the wrong shape or sign, or is not finite.

    """

    spring_coefficients: Array = SPRING_COEFFICIENTS  # type: ignore[assignment]  # array_like
    spring_range: Array = SPRING_RANGE  # type: ignore[assignment]
    coulomb: Array = field(default_factory=_zeros)
    viscous: Array = field(default_factory=_zeros)
    dahl: Array = field(default_factory=_zeros)
    bias: Array = field(default_factory=_zeros)
    stiffness: Array = field(default_factory=_zeros)
    added_inertia: Array = field(default_factory=_zeros)
    coulomb_velocity: float = COULOMB_VELOCITY
    dahl_length: float = DAHL_LENGTH

    if TYPE_CHECKING:  # derived attributes, and array_like arguments
        has_spring: bool = field(init=False)
        has_friction: bool = field(init=False)
        has_dahl: bool = field(init=False)
        has_added_inertia: bool = field(init=False)
        _has_cables: bool = field(init=False)
        _spring: tuple[float, ...] = field(init=False)
        _border: tuple[float, float] = field(init=False)

        def __init__(self, spring_coefficients: ArrayLike = ..., spring_range: ArrayLike = ...,
                     coulomb: ArrayLike = ..., viscous: ArrayLike = ..., dahl: ArrayLike = ...,
                     bias: ArrayLike = ..., stiffness: ArrayLike = ...,
                     added_inertia: ArrayLike = ..., coulomb_velocity: float = ...,
                     dahl_length: float = ...) -> None:
            ...

    def __post_init__(self) -> None:
        """Validate the arguments and store read-only arrays."""
        shapes = {'spring_coefficients': (5,), 'spring_range': (2,),
                  **dict.fromkeys(_PER_JOINT, (N_JOINTS,))}
        for name, shape in shapes.items():
            value = finite(f'effort_model.{name}', getattr(self, name), shape).copy()
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        for name in _NOT_NEGATIVE:
            if getattr(self, name).min() < 0.0:
                raise ArgumentError(f'effort_model.{name}',
                                    f'expected no negative value, got {getattr(self, name)}')
        if self.spring_range[0] >= self.spring_range[1]:
            raise ArgumentError('effort_model.spring_range',
                                f'expected lower < upper, got {self.spring_range}')
        set_ = object.__setattr__
        for name in ('coulomb_velocity', 'dahl_length'):
            set_(self, name, number(f'effort_model.{name}', getattr(self, name), lower=1e-6))
        # Plain numbers for the single states of a stream.
        set_(self, 'has_spring', bool(self.spring_coefficients.any()))
        set_(self, 'has_dahl', bool(self.dahl.any()))
        set_(self, 'has_friction', bool(self.has_dahl or self.coulomb.any() or self.viscous.any()))
        set_(self, '_has_cables', bool(self.stiffness.any()))
        set_(self, 'has_added_inertia', bool(self.added_inertia.any()))
        set_(self, '_spring', tuple(self.spring_coefficients.tolist()))
        set_(self, '_border', tuple(self.spring_range.tolist()))

    @classmethod
    def rigid(cls) -> 'EffortModel':
        """Return the model of a simulator: effort = tau."""
        return cls(spring_coefficients=np.zeros(5))

    def spring(self, q: Array) -> Array:
        """Return the spring effort (..., 7) [N m], zero except at s1, for q (..., 7) [rad]."""
        lower, upper = self._border
        c0, c1, c2, c3, c4 = self._spring
        if q.ndim == 1:  # plain numbers are several times faster for one state
            s1 = min(max(float(q[S1]), lower), upper)
            sin: Array | float = math.sin(s1)
            cos: Array | float = math.cos(s1)
        else:
            angles = np.clip(q[..., S1], lower, upper)
            sin, cos = np.sin(angles), np.cos(angles)
        result = np.zeros(q.shape)
        # sin 2q = 2 sin q cos q, cos 2q = 1 - 2 sin^2 q
        result[..., S1] = (c0 + c4) + c1 * sin + c2 * cos + 2.0 * sin * (c3 * cos - c4 * sin)
        return result

    def spring_is_held(self, q: Array) -> Bools | np.bool_:
        """
        Return whether s1 is outside the spring's range, (...) bool, for q (..., 7) [rad].

        Always false without a spring.
        """
        if q.ndim == 1:  # several times faster
            return np.bool_(self.has_spring
                            and not self._border[0] <= q.item(S1) <= self._border[1])
        s1 = q[..., S1]
        held = (s1 < self._border[0]) | (s1 > self._border[1])
        return held if self.has_spring else np.zeros_like(held)

    def friction(self, qd: Array, presliding: Array | None = None) -> Array:
        """
        Return Coulomb, viscous and Dahl friction, (..., 7) [N m].

        Parameters
        ----------
        qd : ndarray (..., 7)
            Velocity [rad/s].
        presliding : ndarray (..., 7), optional
            Dahl's state z; by default the steady state tanh(qd / coulomb_velocity).

        """
        sliding = np.tanh(qd / self.coulomb_velocity)
        result = self.coulomb * sliding + self.viscous * qd
        if self.has_dahl:
            result += self.dahl * (sliding if presliding is None else presliding)
        return result

    def other(self, q: Array, qdd: Array) -> Array:
        """Return bias, cable and added-inertia effort (..., 7) [N m] for q, qdd (..., 7)."""
        result = self.bias
        if self._has_cables:
            result = result + self.stiffness * q
        if self.has_added_inertia:
            result = result + self.added_inertia * qdd
        return result

    def effort(self, tau: Array, q: Array, qd: Array, qdd: Array,
               presliding: Array | None = None) -> Array:
        """Return the predicted measured effort for joint torques tau, both (..., 7) [N m]."""
        result = tau + self.spring(q) + self.other(q, qdd)
        return result + self.friction(qd, presliding) if self.has_friction else result

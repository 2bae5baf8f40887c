r"""
From torque to effort: what the robot's ``effort`` field measures beyond tau.

    effort = tau + spring(q_s1) + friction + bias + stiffness q + added_inertia qdd

Baxter's upper arm hangs in two strong springs that act on s1, beside the motor. They carry the
part of tau_s1 that the measured effort lacks; written as above the term is positive, for the
motor works against them near the usual poses. A simulator has no springs:
:meth:`EffortModel.rigid` is tau alone.
"""

from dataclasses import dataclass, field
import math
from typing import TYPE_CHECKING

import numpy as np

from .arrays import Array, ArrayLike, Bools
from .exceptions import ArgumentError
from .joints import N_JOINTS, S1
from .validation import finite, number

# Spring at s1, N m: coefficients of 1, sin q, cos q, sin 2q, cos 2q. Fitted to recordings of two
# robots by `baxter_dynamics calibrate` (docs/calibrate.md has the command); a hysteresis of about
# 1 to 1.5 N m is not in it. They are alike in what they sum to, not one by one.
SPRING_COEFFICIENTS = (-5.7466, -8.6679, 38.3573, 9.3798, 2.2237)
# The s1 angles that those recordings cover [rad]. Beyond, the value at the border is held.
SPRING_RANGE = (-1.9, 1.0)

# Width of the Coulomb term's change of sign [rad/s].
COULOMB_VELOCITY = 0.05

# The angle over which Dahl's friction turns round [rad].
DAHL_LENGTH = 0.02

_PER_JOINT = ('coulomb', 'viscous', 'dahl', 'bias', 'stiffness', 'added_inertia')
_NOT_NEGATIVE = ('coulomb', 'viscous', 'dahl')


def _zeros() -> Array:
    return np.zeros(N_JOINTS)


@dataclass(frozen=True, eq=False)
class EffortModel:
    """
    The terms that measured effort has beyond tau; joint order s0 ... w2.

    Its methods take float arrays (..., 7), already validated; leading axes are a batch.

    Attributes
    ----------
    spring_coefficients : array_like (5,)
        Spring at s1 over 1, sin q, cos q, sin 2q, cos 2q [N m].
    spring_range : array_like (2,)
        The s1 angles for which they hold [rad]; beyond, the border's value is held.
    coulomb : array_like (7,)
        Coulomb friction [N m], not negative: ``coulomb * tanh(qd / coulomb_velocity)``.
    viscous : array_like (7,)
        Viscous friction [N m s/rad], not negative: ``viscous * qd``.
    dahl : array_like (7,)
        Dahl's friction [N m], not negative: ``dahl * z``, z of :class:`.presliding.Presliding`.
    bias : array_like (7,)
        Constant offset of the measured effort [N m].
    stiffness : array_like (7,)
        Of the cables that a joint bends [N m/rad], of either sign: ``stiffness * q``.
    added_inertia : array_like (7,)
        Inertia beyond the links' that the measured effort shows [kg m^2], of either sign:
        ``added_inertia * qdd``.
    coulomb_velocity : float
        Width of the Coulomb term's change of sign [rad/s].
    dahl_length : float
        The angle over which Dahl's friction turns round [rad].
    has_spring, has_friction, has_dahl, has_added_inertia : bool
        Whether any of their coefficients is not zero; Dahl's are among the friction's.

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

    if TYPE_CHECKING:  # what follows from the fields, and that those are given as array_like
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
        """Validate, and keep read-only arrays."""
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
        # What a stream asks for again and again, as plain numbers.
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
        """Return the spring's effort, (..., 7) [N m], zero but at s1; q is (..., 7) [rad]."""
        lower, upper = self._border
        c0, c1, c2, c3, c4 = self._spring
        if q.ndim == 1:  # one state of a stream: several times faster on plain numbers
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
        Return where s1 is outside the spring's range, (...) bool; q is (..., 7) [rad].

        Nowhere, where there is no spring.
        """
        if q.ndim == 1:  # several times faster
            return np.bool_(self.has_spring
                            and not self._border[0] <= q.item(S1) <= self._border[1])
        s1 = q[..., S1]
        held = (s1 < self._border[0]) | (s1 > self._border[1])
        return held if self.has_spring else np.zeros_like(held)

    def friction(self, qd: Array, presliding: Array | None = None) -> Array:
        """
        Return Coulomb, viscous and Dahl's friction, (..., 7) [N m].

        Parameters
        ----------
        qd : ndarray (..., 7)
            Velocity [rad/s].
        presliding : ndarray (..., 7), optional
            Dahl's state z. By default that of a joint which has long been moving as it does:
            tanh(qd / coulomb_velocity).

        """
        sliding = np.tanh(qd / self.coulomb_velocity)
        result = self.coulomb * sliding + self.viscous * qd
        if self.has_dahl:
            result += self.dahl * (sliding if presliding is None else presliding)
        return result

    def other(self, q: Array, qdd: Array) -> Array:
        """Return bias, cables and added inertia, (..., 7) [N m]; q, qdd (..., 7)."""
        result = self.bias
        if self._has_cables:
            result = result + self.stiffness * q
        if self.has_added_inertia:
            result = result + self.added_inertia * qdd
        return result

    def effort(self, tau: Array, q: Array, qd: Array, qdd: Array,
               presliding: Array | None = None) -> Array:
        """Return what the robot would measure, (..., 7) [N m], while it needs tau (..., 7)."""
        result = tau + self.spring(q) + self.other(q, qdd)
        return result + self.friction(qd, presliding) if self.has_friction else result

"""
What can be fitted, term by term.

Each term knows its parameters (deviations from what the settings say), the columns of the
regressor that belong to them, and how it is written into the settings.
"""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterator
from dataclasses import dataclass
from dataclasses import replace
from functools import cached_property
from typing import Any
from typing import Protocol

import numpy as np

from .motion import Motion
from ..core.arm import BaxterArm
from ..core.arrays import Array
from ..core.arrays import Bools
from ..core.effort import EffortModel
from ..core.joints import JOINTS
from ..core.joints import N_JOINTS
from ..core.joints import S1
from ..core.parameters import from_pseudo_inertia
from ..core.parameters import inertia_elements
from ..core.parameters import Payload
from ..signals.settings import PredictorSettings

# Of what was fitted: name, unit, value before and after, and uncertainty.
Row = tuple[str, str, float, float, float]

# Candidates for the angle over which Dahl's friction turns round [rad].
_DAHL_LENGTHS = (0.01, 0.02, 0.03, 0.05)

OPTIONAL = ('inertial', 'payload')  # terms that are fitted where asked for, and then in any case

# By which share a term must lower the RMS on what was left out to be kept: of one joint for a
# joint's own term, on the mean for a term of all joints, which may harm some. What has no physics
# behind it must buy more, for it also passes for what the filter does to sharp friction.
_WORTH, _WORTH_OF_ALL, _WORTH_OF_ODD = 0.01, 0.02, 0.05

# What is believed before anything is measured: standard deviations, here as shares of a joint's
# greatest torque, for torques and what makes them.
_TORQUE = 0.04 * np.array([50.0, 50.0, 50.0, 50.0, 15.0, 15.0, 15.0])  # [N m]
_INERTIA = 0.5  # [kg m^2]
_GAIN = 0.2  # of the spring's given shape [-]
_SHAPE = 5.0  # a coefficient of the spring [N m]
_NEW_SHAPE = 100.0  # ... where nothing is known of it
_TILT = 0.3  # horizontal gravity: 1.75 degrees [m/s^2]
_LINK = 0.1  # [-]: 10 % of the mass, and of the radius of gyration for the centre of mass
_PAYLOAD_MASS = 3.0  # [kg]
_PAYLOAD_MOMENT = 0.5  # mass times centre of mass [kg m]

REACH = 1.0  # along an axis, of its centre: next to no mass may say anything [m]

# An orthonormal basis of the symmetric 4 x 4 matrices, (10, 4, 4).
_PAIRS = [(i, k) for i in range(4) for k in range(i, 4)]
_SYMMETRIC = np.zeros((len(_PAIRS), 4, 4))
for _n, (_i, _k) in enumerate(_PAIRS):
    _SYMMETRIC[_n, _i, _k] = _SYMMETRIC[_n, _k, _i] = 1.0 if _i == _k else np.sqrt(0.5)


@dataclass(frozen=True)
class Parameter:
    """One number to fit: a deviation from what the settings say."""

    name: str  # such as 'coulomb s1'
    unit: str
    prior: float  # standard deviation before anything is measured
    lower: float = -np.inf  # least deviation

    def tightened(self, factor: float) -> 'Parameter':
        """Return it with a prior that much narrower."""
        return replace(self, prior=factor * self.prior)


@dataclass(eq=False)
class Sample:
    """Some rows of a motion, and what several terms need of them."""

    motion: Motion
    presliding: Array  # (n, m, 7) Dahl's state for each of the m dahl_lengths()
    arm: BaxterArm

    @cached_property
    def regressor(self) -> Array:
        """Torques per unit of pseudo-inertia, (n, 7, 7, 4, 4)."""
        return self.arm.composite.regressor(self.motion.q, self.motion.qd, self.motion.qdd)

    @cached_property
    def horizontal_gravity(self) -> Array:
        """Torques per unit of gravity along the base's x and y, its size kept, (n, 7, 2)."""
        arm = self.arm
        x, y, z = arm.gravity_vector
        return np.stack([
            BaxterArm(payload=arm.payload, gravity=direction, mount=arm.mount,
                      parameters=arm.parameters).dynamics.gravity(self.motion.q)
            for direction in ((1.0, 0.0, -x / z), (0.0, 1.0, -y / z))], axis=-1)


class Term(Protocol):
    """What every term can do."""

    name: str
    shared: bool  # by all joints, whose own terms are fitted each for itself
    worth: float  # share by which it must lower the RMS
    parameters: tuple[Parameter, ...]

    def acting(self, joint: int) -> list[int]:
        """Return which of the parameters act on a joint."""

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the effort of a joint for a unit of each parameter that acts on it, (n, k)."""

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Add the deviations to the settings."""

    def rows(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
             active: Bools) -> Iterator[Row]:
        """Yield what was fitted."""


class PerJoint:
    """A term of each joint's own: one parameter, one column."""

    shared = False

    def __init__(self, name: str, unit: str, prior: Array, column: Callable[[Sample], Array],
                 lower: Array | None = None, without: Collection[int] = (),
                 worth: float = _WORTH) -> None:
        self.name = name
        self.worth = worth
        self._without = without
        self.setting = f'effort_model.{name}'
        self._column = column
        self.parameters = tuple(
            Parameter(f'{name} {joint}', unit, float(prior[i]),
                      -np.inf if lower is None else -float(lower[i]))
            for i, joint in enumerate(JOINTS))

    def acting(self, joint: int) -> list[int]:
        """Return which of the parameters act on a joint."""
        return [] if joint in self._without else [joint]

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the effort of a joint for a unit of each parameter that acts on it, (n, k)."""
        return self._column(sample)[:, joint, None]

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Add the deviations to the settings."""
        values[self.setting] = tuple(np.asarray(values[self.setting]) + deviation)

    def rows(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
             active: Bools) -> Iterator[Row]:
        """Yield name, unit, value before and after, and uncertainty of each that was fitted."""
        deviation = np.sqrt(np.diag(covariance))
        for i in np.flatnonzero(active):
            yield (self.parameters[i].name, self.parameters[i].unit, before[self.setting][i],
                   after[self.setting][i], deviation[i])


class DahlFriction(PerJoint):
    """Dahl's friction, once for each candidate length; a fit uses one of them."""

    def __init__(self, lower: Array, index: int, length: float) -> None:
        super().__init__('dahl', 'N m', _TORQUE, lambda sample: sample.presliding[:, index], lower)
        self.length = length

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Add the deviations, and set the length."""
        super().update(values, deviation)
        values['effort_model.dahl_length'] = self.length


class Spring:
    """The spring at s1: its shape, or a gain on the shape it has; its offset is the bias."""

    name = 'spring'
    shared = False
    worth = _WORTH

    def __init__(self, model: EffortModel, shape: bool, constant: bool = False) -> None:
        self._model = model
        self._constant = constant
        names = ('1', 'sin q', 'cos q', 'sin 2q', 'cos 2q')
        if shape:
            self._units = np.eye(5)[0 if constant else 1:]
            prior = _NEW_SHAPE if constant else _SHAPE
            self.parameters = tuple(Parameter(f'spring {name}', 'N m', prior)
                                    for name in names[0 if constant else 1:])
        else:
            self._units = model.spring_coefficients[None]
            self.parameters = (Parameter('spring gain', '-', _GAIN),)

    def acting(self, joint: int) -> list[int]:
        """Return which of the parameters act on a joint: all on s1."""
        return list(range(len(self.parameters))) if joint == S1 else []

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the effort of s1 for a unit of each parameter, (n, k)."""
        springs = [EffortModel(spring_coefficients=unit, spring_range=self._model.spring_range)
                   for unit in self._units]
        return np.stack([spring.spring(sample.motion.q)[:, S1] for spring in springs], axis=1)

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Add the deviations to the settings."""
        coefficients = np.asarray(values['effort_model.spring_coefficients'])
        values['effort_model.spring_coefficients'] = tuple(coefficients + deviation @ self._units)

    def rows(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
             active: Bools) -> Iterator[Row]:
        """Yield name, unit, value before and after, and uncertainty of each that was fitted."""
        start, end = (np.asarray(values['effort_model.spring_coefficients'])
                      for values in (before, after))
        inverse = np.linalg.pinv(self._units)
        for i, parameter in enumerate(self.parameters):
            yield (parameter.name, parameter.unit, float(start @ inverse[:, i]),
                   float(end @ inverse[:, i]), np.sqrt(covariance[i, i]))


class Tilt:
    """The tilt of the robot's base: the horizontal components of gravity."""

    name = 'tilt'
    shared = True
    worth = _WORTH_OF_ALL
    parameters: tuple[Parameter, ...] = (Parameter('gravity x', 'm/s^2', _TILT),
                                         Parameter('gravity y', 'm/s^2', _TILT))

    def acting(self, joint: int) -> list[int]:
        """Return which of the parameters act on a joint: both."""
        return [0, 1]

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the joint's torque for a unit of each component, (n, 2)."""
        return sample.horizontal_gravity[:, joint]

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Turn gravity; its size stays."""
        gravity = np.asarray(values['gravity'], dtype=float)
        x, y = gravity[:2] + deviation
        z = np.sqrt(gravity @ gravity - x * x - y * y)
        values['gravity'] = (float(x), float(y), float(np.copysign(z, gravity[2])))

    def rows(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
             active: Bools) -> Iterator[Row]:
        """Yield name, unit, value before and after, and uncertainty of each component."""
        for i, parameter in enumerate(self.parameters):
            yield (parameter.name, parameter.unit, before['gravity'][i], after['gravity'][i],
                   np.sqrt(covariance[i, i]))


class Links:
    r"""
    The links' inertial parameters, under a physical prior.

    Pseudo-inertias are fitted as J = L (1 + S) L^T, where L L^T is what the settings say, with a
    normal prior on the symmetric S. It is the second-order form of the distance between bodies
    that does not depend on units or frames (Lee, Wensing and Park 2020), and J stays that of a
    rigid body while 1 + S > 0.
    """

    name = 'inertial'
    shared = True
    worth = _WORTH_OF_ALL

    def __init__(self, arm: BaxterArm) -> None:
        self._root = np.linalg.cholesky(arm.parameters.pseudo_inertia)
        self._units = self._root[:, None] @ _SYMMETRIC @ self._root.swapaxes(-1, -2)[:, None]
        self.parameters = tuple(
            Parameter(f'link {i + 1} S{a + 1}{b + 1}', '-', _LINK)
            for i in range(N_JOINTS) for a, b in _PAIRS)

    def acting(self, joint: int) -> list[int]:
        """Return which of the parameters act on a joint: those of the links beyond it."""
        return list(range(10 * joint, 10 * N_JOINTS))

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the joint's torque for a unit of each parameter, (n, 10 (7 - joint))."""
        moved = np.einsum('nlab,lkba->nlk', sample.regressor[:, joint, joint:],
                          self._units[joint:], optimize=True)
        return moved.reshape(len(moved), -1)

    def least_eigenvalues(self, deviation: Array) -> Array:
        """Return the least eigenvalue of each link's 1 + S, (7,)."""
        s = np.einsum('lk,kab->lab', deviation.reshape(N_JOINTS, -1), _SYMMETRIC)
        return 1.0 + np.linalg.eigvalsh(s)[:, 0]

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Write the links into the settings."""
        pseudo = self._root @ self._root.swapaxes(-1, -2) + np.einsum(
            'lk,lkab->lab', deviation.reshape(N_JOINTS, -1), self._units)
        mass, center, inertia = from_pseudo_inertia(pseudo)
        values['links.mass'] = tuple(mass)
        values['links.center_of_mass'] = tuple(center.ravel())
        values['links.inertia'] = tuple(inertia_elements(inertia).ravel())

    def rows(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
             active: Bools) -> Iterator[Row]:
        """Yield name, unit, value before and after, and uncertainty of masses and moments."""
        for link in range(N_JOINTS):
            own = slice(10 * link, 10 * link + 10)
            for name, unit, element in (('mass', 'kg', (3, 3)), ('moment x', 'kg m', (0, 3)),
                                        ('moment y', 'kg m', (1, 3)),
                                        ('moment z', 'kg m', (2, 3))):
                gradient = self._units[(link, slice(None)) + element]
                variance: Any = gradient @ covariance[own, own] @ gradient
                yield (f'link {link + 1} {name}', unit, _moment(before, link, element[0]),
                       _moment(after, link, element[0]), np.sqrt(variance))


class Tool:
    """
    What the hand carries: mass, and mass times centre of mass; inertia is that of a point.

    Attributes
    ----------
    fixed : tuple
        Which of the parameters follow from the others: the second moments m c c^T.

    """

    name = 'payload'
    shared = True
    worth = _WORTH_OF_ALL
    moments = tuple(map(_PAIRS.index, ((0, 3), (1, 3), (2, 3))))
    mass = _PAIRS.index((3, 3))
    fixed = tuple(n for n, (_, k) in enumerate(_PAIRS) if k < 3)

    def __init__(self, payload: Payload) -> None:
        self._base = payload
        names = {self.mass: ('payload mass', 'kg', _PAYLOAD_MASS, -payload.mass)}
        names.update({n: (f'payload moment {axis}', 'kg m', _PAYLOAD_MOMENT, -np.inf)
                      for n, axis in zip(self.moments, 'xyz')})
        self.parameters = tuple(
            Parameter(*names.get(n, (f'payload second moment {n}', 'kg m^2', 1.0, -np.inf)))
            for n in range(len(_PAIRS)))

    def acting(self, joint: int) -> list[int]:
        """Return which of the parameters act on a joint: all."""
        return list(range(len(_PAIRS)))

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the joint's torque for a unit of each parameter, (n, 10)."""
        y = sample.regressor[:, joint, -1]
        return np.stack([y[:, i, k] if i == k else y[:, i, k] + y[:, k, i] for i, k in _PAIRS], 1)

    def total(self, deviation: Array) -> tuple[float, Array]:
        """Return the payload's mass [kg] and centre of mass (3,) [m]."""
        mass = max(self._base.mass + deviation[self.mass], 0.0)
        moment = self._base.mass * np.array(self._base.center_of_mass) + deviation[
            list(self.moments)]
        return mass, np.clip(moment / mass, -REACH, REACH) if mass > 1e-3 else np.zeros(3)

    def second_moments(self, deviation: Array) -> Array:
        """Return what the fixed parameters must be, given the others, (6,) [kg m^2]."""
        mass, center = self.total(deviation)
        before = np.array(self._base.center_of_mass)
        change = mass * np.outer(center, center) - self._base.mass * np.outer(before, before)
        return np.array([change[_PAIRS[n]] for n in self.fixed])

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Write the payload into the settings."""
        mass, center = self.total(deviation)
        values['payload.mass'] = float(mass)
        values['payload.center_of_mass'] = tuple(center)
        if mass == 0.0:
            values['payload.inertia'] = (0.0,) * 6

    def rows(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
             active: Bools) -> Iterator[Row]:
        """Yield name, unit, value before and after, and uncertainty of mass and centre."""
        mass = after['payload.mass']
        yield ('payload mass', 'kg', before['payload.mass'], mass,
               np.sqrt(covariance[self.mass, self.mass]))
        if mass < 1e-3:
            return
        for i, (axis, own) in enumerate(zip('xyz', self.moments)):
            center = after['payload.center_of_mass'][i]
            pair = covariance[np.ix_([own, self.mass], [own, self.mass])]
            gradient = np.array([1.0, -center]) / mass
            yield (f'payload center {axis}', 'm', before['payload.center_of_mass'][i], center,
                   np.sqrt(gradient @ pair @ gradient))


def dahl_lengths(model: EffortModel) -> tuple[float, ...]:
    """Return the lengths to try [rad]: the model's own where it has Dahl's friction."""
    return (model.dahl_length,) if model.has_dahl else _DAHL_LENGTHS


def all_terms(settings: PredictorSettings, shape: bool, constant: bool = False) -> list[Term]:
    """
    Return all terms, in the order in which they are tried, each on top of those before it.

    Parameters
    ----------
    settings : PredictorSettings
        What the parameters are deviations from.
    shape : bool
        Whether the spring's shape is fitted.
    constant : bool
        Whether the spring's shape has its constant, which otherwise is s1's bias.

    """
    model = settings.effort_model
    terms: list[Term] = [
        PerJoint('bias', 'N m', _TORQUE, _ones),
        Tool(settings.arm.payload),  # friction pays next to nothing while a load is not known
    ]
    if shape or model.has_spring:
        terms.append(Spring(model, shape, constant))
    terms += [
        PerJoint('coulomb', 'N m', _TORQUE,
                 lambda sample: np.tanh(sample.motion.qd / model.coulomb_velocity), model.coulomb),
        PerJoint('viscous', 'N m s/rad', _TORQUE, lambda sample: sample.motion.qd, model.viscous),
        *(DahlFriction(model.dahl, *pair) for pair in enumerate(dahl_lengths(model))),
        PerJoint('added_inertia', 'kg m^2', np.full(N_JOINTS, _INERTIA),
                 lambda sample: sample.motion.qdd, worth=_WORTH_OF_ODD),
    ]
    if settings.arm.gravity_vector[2]:
        terms.append(Tilt())
    return [
        *terms, Links(settings.arm),
        # Last, for over a small range a spring passes for many things; at s1 there is the spring.
        PerJoint('stiffness', 'N m/rad', _TORQUE, lambda sample: sample.motion.q, without=(S1,),
                 worth=_WORTH_OF_ODD),
    ]


def _ones(sample: Sample) -> Array:
    return np.ones(sample.motion.q.shape)


def _moment(values: dict[str, Any], link: int, axis: int) -> float:
    """Return a link's mass (axis 3) [kg] or mass times centre of mass along an axis [kg m]."""
    mass = values['links.mass'][link]
    return mass if axis == 3 else mass * values['links.center_of_mass'][3 * link + axis]

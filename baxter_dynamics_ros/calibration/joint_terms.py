"""Terms of single joints: friction, bias, cables, added inertia, spring at s1."""

from collections.abc import Callable, Collection, Iterator
from typing import Any

import numpy as np

from .term import Fitted, Parameter, Sample, WORTH
from ..model.arrays import Array, Bools
from ..model.effort import EffortModel
from ..model.joints import N_JOINTS, S1

# Standard deviations of the priors. Those of torques are shares of the largest joint torque.
_LARGEST = np.array([50.0, 50.0, 50.0, 50.0, 15.0, 15.0, 15.0])  # torque of each joint [N m]
TORQUE = 0.04 * _LARGEST  # [N m]
# Offsets of 30 to 40 N m at s1 were measured on some robots.
OFFSET = _LARGEST  # [N m]
GAIN = 'gain'  # component of a spring with a fixed shape

_GAIN = 0.2  # gain of a fixed spring shape [-]
_SHAPE = 5.0  # coefficient of the spring [N m]
_NEW_SHAPE = 100.0  # ... without prior knowledge [N m]


class PerJoint:
    """Term with one parameter and one column per joint."""

    shared = False

    def __init__(self, name: str, unit: str, prior: Array, column: Callable[[Sample], Array],
                 lower: Array | None = None, without: Collection[int] = (),
                 worth: float = WORTH) -> None:
        self.name = name
        self.worth = worth
        self._without = without
        self.setting = f'effort_model.{name}'
        self._column = column
        self.unit = unit
        self.parameters = tuple(
            Parameter(float(prior[i]), -np.inf if lower is None else -float(lower[i]))
            for i in range(N_JOINTS))

    def acting(self, joint: int) -> list[int]:
        """Return the indices of the parameters that act on a joint."""
        return [] if joint in self._without else [joint]

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the effort of a joint for a unit of each parameter that acts on it, (n, k)."""
        return self._column(sample)[:, joint, None]

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Add the deviations to the settings."""
        values[self.setting] = tuple(np.asarray(values[self.setting]) + deviation)

    def fitted(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
               active: Bools) -> Iterator[Fitted]:
        """Yield each quantity that was fitted."""
        deviation = np.sqrt(np.diag(covariance))
        for i in np.flatnonzero(active).tolist():
            yield Fitted(self.name, i, '', self.unit, before[self.setting][i],
                         after[self.setting][i], float(deviation[i]))


class DahlFriction(PerJoint):
    """Dahl friction for one candidate length; a fit uses one of the candidates."""

    def __init__(self, lower: Array, index: int, length: float) -> None:
        super().__init__('dahl', 'N m', TORQUE, lambda sample: sample.presliding[:, index], lower)
        self.length = length

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Add the deviations, and set the length."""
        super().update(values, deviation)
        values['effort_model.dahl_length'] = self.length


class Spring:
    """Spring at s1: its shape, or a gain of a fixed shape; its offset is part of the bias."""

    name = 'spring'
    shared = False
    worth = WORTH

    def __init__(self, model: EffortModel, shape: bool, constant: bool = False) -> None:
        self._model = model
        self._constant = constant
        names = ('1', 'sin q', 'cos q', 'sin 2q', 'cos 2q')
        if shape:
            self._units = np.eye(5)[0 if constant else 1:]
            prior = _NEW_SHAPE if constant else _SHAPE
            self._components = names[0 if constant else 1:]
            self.parameters = tuple(Parameter(prior) for _ in self._components)
        else:
            self._units = model.spring_coefficients[None]
            self._components = (GAIN,)
            self.parameters = (Parameter(_GAIN),)

    def acting(self, joint: int) -> list[int]:
        """Return the indices of the parameters that act on a joint: all on s1."""
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

    def fitted(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
               active: Bools) -> Iterator[Fitted]:
        """Yield each quantity that was fitted."""
        start, end = (np.asarray(values['effort_model.spring_coefficients'])
                      for values in (before, after))
        inverse = np.linalg.pinv(self._units)
        unit = '-' if self._components == (GAIN,) else 'N m'
        for i, component in enumerate(self._components):
            yield Fitted(self.name, S1, component, unit, float(start @ inverse[:, i]),
                         float(end @ inverse[:, i]), float(np.sqrt(covariance[i, i])))

"""Terms of single joints: friction, bias, cables, added inertia, spring at s1."""

from collections.abc import Callable, Collection
from dataclasses import replace
from typing import Any

import numpy as np

from .term import Sample, Term, WORTH, WORTH_OF_ODD
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array
from ..model.effort import EffortModel
from ..model.joints import JOINTS, N_JOINTS, S1

# Standard deviations of the priors. Those of torques are shares of the largest joint torque.
_LARGEST = np.array([50.0, 50.0, 50.0, 50.0, 15.0, 15.0, 15.0])  # torque of each joint [N m]
TORQUE = 0.04 * _LARGEST  # [N m]
# Offsets of 30 to 40 N m at s1 were measured on some robots.
OFFSET = _LARGEST  # [N m]
GAIN = 'gain'  # component of a spring with a fixed shape

_GAIN = 0.2  # gain of a fixed spring shape [-]
_SHAPE = 5.0  # coefficient of the spring [N m]
_NEW_SHAPE = 100.0  # ... without prior knowledge [N m]
_CROSSTALK = 0.05  # share of another joint's effort [-]
_COMPONENTS = ('1', 'sin q', 'cos q', 'sin 2q', 'cos 2q')


class PerJoint(Term):
    """Term with one parameter and one column per joint."""

    def __init__(self, name: str, unit: str, prior: Array, column: Callable[[Sample], Array],
                 least: float = -np.inf, present: Array | float = 0.0,
                 without: Collection[int] = (), worth: float = WORTH) -> None:
        self.name = name
        self.worth = worth
        self.prior = prior
        self.lower = np.full(N_JOINTS, least) - present
        self.acts = np.eye(N_JOINTS, dtype=bool)
        self.acts[list(without)] = False
        self.quantities = [(joint, '', unit) for joint in range(N_JOINTS)]
        self._column = column

    def columns(self, sample: Sample, joint: int) -> Array:
        return self._column(sample)[:, joint, None]

    def updated(self, settings: PredictorSettings, deviation: Array) -> PredictorSettings:
        return with_terms(settings, **{self.name: self.read(settings) + deviation})

    def read(self, settings: PredictorSettings) -> Array:
        return np.array(getattr(settings.effort_model, self.name))


class DahlFriction(PerJoint):
    """Dahl friction for one candidate length; a fit uses one of the candidates."""

    def __init__(self, present: Array, length: float) -> None:
        super().__init__('dahl', 'N m', TORQUE, lambda sample: sample.presliding[length],
                         0.0, present)
        self.length = length

    def updated(self, settings: PredictorSettings, deviation: Array) -> PredictorSettings:
        return with_terms(super().updated(settings, deviation), dahl_length=self.length)


class Spring(Term):
    """Spring at s1: its shape, or a gain of a fixed shape; its offset is part of the bias."""

    name = 'spring'

    def __init__(self, model: EffortModel, shape: bool, constant: bool = False) -> None:
        self._model = model
        first = 0 if constant else 1
        self._units = np.eye(5)[first:] if shape else model.spring_coefficients[None]
        self.quantities = ([(S1, component, 'N m') for component in _COMPONENTS[first:]]
                           if shape else [(S1, GAIN, '-')])
        n = len(self.quantities)
        self.prior = np.full(n, _GAIN if not shape else _NEW_SHAPE if constant else _SHAPE)
        self.lower = np.full(n, -np.inf)
        self.acts = np.zeros((N_JOINTS, n), dtype=bool)
        self.acts[S1] = True

    def columns(self, sample: Sample, joint: int) -> Array:
        springs = [EffortModel(spring_coefficients=unit, spring_range=self._model.spring_range)
                   for unit in self._units]
        return np.stack([spring.spring(sample.motion.q)[:, S1] for spring in springs], axis=1)

    def updated(self, settings: PredictorSettings, deviation: Array) -> PredictorSettings:
        coefficients = settings.effort_model.spring_coefficients + deviation @ self._units
        return with_terms(settings, spring_coefficients=coefficients)

    def read(self, settings: PredictorSettings) -> Array:
        return settings.effort_model.spring_coefficients @ np.linalg.pinv(self._units)


class Crosstalk(Term):
    """Shares of the effort of other joints in the measured effort, 42 in the order of the rows."""

    name = 'crosstalk'
    separate = True
    least = 0.02  # smaller ones, mostly at the wrist, imitate other errors and do not travel
    worth = WORTH_OF_ODD

    def __init__(self) -> None:
        rows, columns = np.nonzero(~np.eye(N_JOINTS, dtype=bool))
        self.prior = np.full(len(rows), _CROSSTALK)
        self.lower = np.full(len(rows), -np.inf)
        self.acts = rows == np.arange(N_JOINTS)[:, None]
        self.quantities = [(row, f'of {JOINTS[column]}', '-')
                           for row, column in zip(rows.tolist(), columns.tolist())]
        self._where = rows, columns

    def columns(self, sample: Sample, joint: int) -> Array:
        return np.delete(sample.effort, joint, axis=1)

    def updated(self, settings: PredictorSettings, deviation: Array) -> PredictorSettings:
        matrix = np.reshape(settings.effort_model.crosstalk, (N_JOINTS, N_JOINTS))
        matrix[self._where] += deviation
        return with_terms(settings, crosstalk=matrix.ravel())

    def read(self, settings: PredictorSettings) -> Array:
        return np.reshape(settings.effort_model.crosstalk, (N_JOINTS, N_JOINTS))[self._where]


def with_terms(settings: PredictorSettings, **terms: Any) -> PredictorSettings:
    """Return the settings with other terms of the effort model."""
    return replace(settings, effort_model=replace(settings.effort_model, **terms))

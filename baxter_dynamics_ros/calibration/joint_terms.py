"""Terms of a fit: their interface, and the terms of single joints."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .calibration_results import Fitted
from .fit_data import Motion
from ..estimation.settings import PredictorSettings, SETTINGS
from ..model import Array, BaxterArm, Bools, EffortModel, JOINTS, N_JOINTS, S1
from ..model.arm import with_gravity

# Minimum relative improvement of the cross-validated RMS for which a term is kept: of the joint
# for a term of one joint, of the mean for a shared term. Terms without a physical basis need more,
# because they can also imitate the effect of the filter on sharp friction.
WORTH, WORTH_OF_ALL, WORTH_OF_ODD = 0.01, 0.02, 0.05

# Standard deviations of the priors. Those of torques are shares of the largest joint torque.
_LARGEST = np.array([50.0, 50.0, 50.0, 50.0, 15.0, 15.0, 15.0])  # torque of each joint [N m]
TORQUE = 0.04 * _LARGEST  # [N m]
OFFSET = _LARGEST  # [N m]; offsets of 30 to 40 N m at s1 were measured on some robots
_GAIN = 0.2  # gain of a fixed spring shape [-]
_SHAPE = 5.0  # coefficient of the spring [N m]
_NEW_SHAPE = 100.0  # ... without prior knowledge [N m]
_CROSSTALK = 0.05  # share of another joint's effort [-]

_COMPONENTS = ('1', 'sin q', 'cos q', 'sin 2q', 'cos 2q')  # of the spring
_UNITS = {setting.name: setting.unit for setting in SETTINGS}


@dataclass(eq=False)
class Sample:
    """Rows of a motion, and quantities that several terms use."""

    motion: Motion
    presliding: dict[float, Array]  # Dahl's state (n, 7) for each length [rad]
    arm: BaxterArm
    effort: Array  # (n, 7) of the present model, without crosstalk [N m]

    @cached_property
    def regressor(self) -> Array:
        """Torques per unit of each base parameter, (n, 7, 43 or 45)."""
        return self.arm.regressor(self.motion.q, self.motion.qd, self.motion.qdd)

    @cached_property
    def horizontal_gravity(self) -> Array:
        """Torques per unit of gravity along the base's x and y, its size kept, (n, 7, 2)."""
        x, y, z = self.arm.gravity_vector
        return np.stack([with_gravity(self.arm, direction).gravity(self.motion.q)
                         for direction in ((1.0, 0.0, -x / z), (0.0, 1.0, -y / z))], axis=-1)


class Term(ABC):
    """Term of a fit; its p parameters are deviations from the settings."""

    name: str  # shared by alternatives of the same term
    quantities: list[tuple[int | None, str, str]]  # reported: joint or link, component, unit
    shared = False  # whether the term acts on all joints together
    separate = False  # whether each parameter is selected by itself, and must help in most folds
    least = 0.0  # minimum absolute value of a parameter that is selected by itself
    worth = WORTH

    def __init__(self, prior: Array, acts: Bools | bool = True,
                 lower: Array | float = -np.inf) -> None:
        self.prior = prior  # (p,) standard deviations
        self.acts = np.zeros((N_JOINTS, len(prior)), dtype=bool) | acts  # on which joints
        self.lower = np.zeros(len(prior)) + lower  # (p,) bounds
        self.tied = np.zeros(len(prior), dtype=bool)  # whether a parameter follows from the others

    @abstractmethod
    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the effort of a joint for a unit of each parameter that acts on it, (n, k)."""

    @abstractmethod
    def values(self, settings: PredictorSettings, deviation: Array) -> dict[str, Any]:
        """Return the settings that the deviations (p,) change, by name."""

    @abstractmethod
    def read(self, settings: PredictorSettings) -> Array:
        """Return the reported quantities (m,) from the settings."""

    def jacobian(self, settings: PredictorSettings) -> Array:
        """Return the derivative of the quantities by the parameters, (m, p)."""
        return np.eye(len(self.prior))

    def fitted(self, before: PredictorSettings, after: PredictorSettings, covariance: Array,
               active: Bools) -> list[Fitted]:
        """Return the quantities that the active parameters (p,) change."""
        jacobian = self.jacobian(after)
        deviation = np.sqrt(np.diag(jacobian @ covariance @ jacobian.T))
        numbers = np.stack([self.read(before), self.read(after), deviation], axis=1).tolist()
        return [Fitted(self.name, *quantity, *row)
                for quantity, row, gradient in zip(self.quantities, numbers, jacobian)
                if gradient[active].any()]


class EffortTerm(Term):
    """Term whose parameters change one setting of the effort model in orthogonal directions."""

    setting: str  # name within the effort model
    directions: Array  # (p, n) change of the setting for a unit of each parameter
    constants: dict[str, float] = {}  # further settings with this term

    def values(self, settings: PredictorSettings, deviation: Array) -> dict[str, Any]:
        present = getattr(settings.effort_model, self.setting).ravel()
        values = {self.setting: present + deviation @ self.directions, **self.constants}
        return {f'effort_model.{name}': value for name, value in values.items()}

    def read(self, settings: PredictorSettings) -> Array:
        present = getattr(settings.effort_model, self.setting).ravel()
        return present @ self.directions.T / (self.directions ** 2).sum(1)


class PerJoint(EffortTerm):
    """Term with one parameter per joint, that of the effort model with the same name."""

    directions = np.eye(N_JOINTS)

    def __init__(self, name: str, column: Callable[[Sample], Array], prior: Array = TORQUE,
                 lower: Array | float = -np.inf, worth: float = WORTH,
                 without: Collection[int] = (), **constants: float) -> None:
        super().__init__(prior, np.eye(N_JOINTS, dtype=bool), lower)
        self.acts[list(without)] = False
        self.name = self.setting = name
        self.worth, self.constants = worth, constants
        self.quantities = [(joint, '', _UNITS[f'effort_model.{name}'])
                           for joint in range(N_JOINTS)]
        self._column = column  # effort (n, 7) for a unit of each parameter

    def columns(self, sample: Sample, joint: int) -> Array:
        return self._column(sample)[:, joint, None]


class Spring(EffortTerm):
    """
    Spring at s1: its shape, or a gain of a fixed shape.

    Its constant is part of the bias of s1, unless the shape is fitted without a bias.
    """

    name, setting = 'spring', 'spring_coefficients'

    def __init__(self, model: EffortModel, shape: bool, constant: bool = False) -> None:
        first = 0 if constant else 1
        self._range = model.spring_range
        self.directions = np.eye(5)[first:] if shape else model.spring_coefficients[None]
        self.quantities = ([(S1, component, 'N m') for component in _COMPONENTS[first:]]
                           if shape else [(S1, 'gain', '-')])
        deviation = _GAIN if not shape else _NEW_SHAPE if constant else _SHAPE
        super().__init__(np.full(len(self.quantities), deviation),
                         np.arange(N_JOINTS)[:, None] == S1)

    def columns(self, sample: Sample, joint: int) -> Array:
        angle = np.clip(sample.motion.q[:, S1], *self._range)
        return np.stack([np.ones(len(angle)), np.sin(angle), np.cos(angle), np.sin(2 * angle),
                         np.cos(2 * angle)], axis=1) @ self.directions.T


class Crosstalk(EffortTerm):
    """Shares of the effort of other joints in the measured effort, 42 in the order of the rows."""

    name = setting = 'crosstalk'
    separate = True
    least = 0.02  # smaller ones, mostly at the wrist, imitate other errors and do not travel
    worth = WORTH_OF_ODD
    where = np.flatnonzero(~np.eye(N_JOINTS, dtype=bool))  # in the matrix, row by row
    directions = np.eye(N_JOINTS ** 2)[where]
    quantities = [(k // N_JOINTS, f'of {JOINTS[k % N_JOINTS]}', '-') for k in where.tolist()]

    def __init__(self) -> None:
        super().__init__(np.full(len(self.where), _CROSSTALK),
                         self.where // N_JOINTS == np.arange(N_JOINTS)[:, None])

    def columns(self, sample: Sample, joint: int) -> Array:
        return np.delete(sample.effort, joint, axis=1)

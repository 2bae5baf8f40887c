"""Interface of the terms of a fit, and the types that they share."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .fit_data import Motion
from ..estimation.settings import PredictorSettings
from ..model.arm import BaxterArm
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS


@dataclass(frozen=True)
class Fitted:
    """One quantity after the fit."""

    term: str  # name of the term
    joint: 'int | None'  # index of the joint or of the link; None if shared by all joints
    component: str  # such as 'sin q' or 'mass'; empty if the term has one quantity per joint
    unit: str
    before: float
    value: float
    deviation: float  # standard deviation


# Minimum relative improvement of the cross-validated RMS for which a term is kept: of the joint
# for a term of one joint, of the mean for a shared term. Terms without a physical basis need more,
# because they can also imitate the effect of the filter on sharp friction.
WORTH, WORTH_OF_ALL, WORTH_OF_ODD = 0.01, 0.02, 0.05


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
        arm = self.arm
        x, y, z = arm.gravity_vector
        return np.stack([
            BaxterArm(payload=arm.payload, gravity=direction, mount=arm.mount,
                      parameters=arm.parameters).gravity(self.motion.q)
            for direction in ((1.0, 0.0, -x / z), (0.0, 1.0, -y / z))], axis=-1)


class Term(ABC):
    """
    Term of a fit; its p parameters are deviations from the settings.

    Attributes
    ----------
    name : str
        Name, which alternatives of the same term share.
    prior, lower : ndarray (p,)
        Standard deviation of the prior, and lower bound of each parameter.
    acts : ndarray (7, p) of bool
        Whether a parameter acts on a joint.
    quantities : list of tuple
        Joint or link, component and unit of each reported quantity.
    shared : bool
        Whether the term acts on all joints together.
    separate : bool
        Whether each parameter is selected by itself, and must help in most folds.
    least : float
        Minimum of the absolute value of a parameter that is selected by itself.
    worth : float
        Minimum relative improvement of the RMS for which the term is kept.

    """

    name: str
    prior: Array
    lower: Array
    acts: Bools
    quantities: list[tuple[int | None, str, str]]
    shared = False
    separate = False
    least = 0.0
    worth = WORTH

    @abstractmethod
    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the effort of a joint for a unit of each parameter that acts on it, (n, k)."""

    @abstractmethod
    def updated(self, settings: PredictorSettings, deviation: Array) -> PredictorSettings:
        """Return the settings with the deviations (p,)."""

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


class SharedTerm(Term):
    """Term whose parameters act on several joints."""

    shared = True
    worth = WORTH_OF_ALL

    def __init__(self, prior: Array) -> None:
        self.prior = prior
        self.lower = np.full(len(prior), -np.inf)
        self.acts = np.ones((N_JOINTS, len(prior)), dtype=bool)

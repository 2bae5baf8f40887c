"""Interface of the terms of a fit, and the types that they share."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from .fit_data import Motion
from ..model.arm import BaxterArm
from ..model.arrays import Array, Bools


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


@dataclass(frozen=True)
class Parameter:
    """Parameter of a fit: a deviation from the settings."""

    prior: float  # standard deviation of the prior
    lower: float = -np.inf  # lower bound of the deviation

    def tightened(self, factor: float) -> 'Parameter':
        """Return the parameter with its prior scaled by the factor."""
        return replace(self, prior=factor * self.prior)


@dataclass(eq=False)
class Sample:
    """Rows of a motion, and quantities that several terms use."""

    motion: Motion
    presliding: Array  # (n, m, 7) Dahl's state for each of the m dahl_lengths()
    arm: BaxterArm

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


class Term(Protocol):
    """Interface of a term."""

    name: str
    shared: bool  # whether the term acts on all joints together
    worth: float  # minimum relative improvement of the RMS
    parameters: tuple[Parameter, ...]

    def acting(self, joint: int) -> list[int]:
        """Return the indices of the parameters that act on a joint."""

    def columns(self, sample: Sample, joint: int) -> Array:
        """Return the effort of a joint for a unit of each parameter that acts on it, (n, k)."""

    def update(self, values: dict[str, Any], deviation: Array) -> None:
        """Add the deviations to the settings."""

    def fitted(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
               active: Bools) -> Iterator[Fitted]:
        """Yield each quantity that was fitted."""

"""What the terms of a fit have in common: parameters, samples, interface."""

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
    joint: 'int | None'  # index of its joint, or of the joint that moves the link; None of all
    component: str  # which of several quantities, such as 'sin q' or 'mass'; empty for the only
    unit: str
    before: float
    value: float
    deviation: float  # standard deviation


# By which share a term must lower the RMS on what was left out to be kept: of one joint for a
# joint's own term, on the mean for a term of all joints, which may harm some. What has no physics
# behind it must buy more, for it also passes for what the filter does to sharp friction.
WORTH, WORTH_OF_ALL, WORTH_OF_ODD = 0.01, 0.02, 0.05


@dataclass(frozen=True)
class Parameter:
    """One number to fit: a deviation from what the settings say."""

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
                      parameters=arm.parameters).gravity(self.motion.q)
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

    def fitted(self, before: dict[str, Any], after: dict[str, Any], covariance: Array,
               active: Bools) -> Iterator[Fitted]:
        """Yield what was fitted."""

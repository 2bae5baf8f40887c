"""What a calibration finds: plain data, for files, reports and people."""

from dataclasses import dataclass
from typing import Any, TYPE_CHECKING

import numpy as np

from .lag import Lag
from ..model.arrays import Array

if TYPE_CHECKING:
    from .selection import Step


@dataclass(frozen=True, eq=False)
class Fitted:
    """A parameter after the fit."""

    term: str
    name: str
    unit: str
    before: float
    after: float
    uncertainty: float  # standard deviation


@dataclass(frozen=True, eq=False)
class Judged:
    """A recording, or a part of one, that a fit never saw."""

    name: str
    duration: float  # [s]
    before: Array  # RMS (7,) of the residual with the settings before [N m]
    after: Array  # ... with what the others gave


@dataclass(frozen=True, eq=False)
class Calibration:
    """
    What a calibration found.

    Attributes
    ----------
    arm : str
        'right' or 'left'.
    before, values : dict
        All settings of the predictor, before and calibrated; the velocity lag is the measured one
        in both.
    parameters : list of Fitted
        What was fitted.
    steps : list of Step
        What each term bought, on data left out; the first is the model before.
    judged : list of Judged
        Each recording, predicted with what the others gave.
    by_time : bool
        Whether they are parts of one recording.
    lag : Lag or None
        Of the velocity.
    warnings : tuple of str
        What a reader should know, a line each.
    samples, duration : int, float
        How much was fitted to [-, s].
    s1_range : tuple
        Between which angles s1 was nearly all the time [rad].

    """

    arm: str
    before: dict[str, Any]
    values: dict[str, Any]
    parameters: list[Fitted]
    steps: 'list[Step]'
    judged: list[Judged]
    by_time: bool
    lag: 'Lag | None'
    warnings: tuple[str, ...]
    samples: int
    duration: float
    s1_range: tuple[float, float]

    @property
    def rms_before(self) -> Array:
        """RMS (7,) over all that was left out, with the settings before [N m]."""
        return _pooled([(j.duration, j.before) for j in self.judged])

    @property
    def rms_after(self) -> Array:
        """RMS (7,) over all that was left out, calibrated [N m]."""
        return _pooled([(j.duration, j.after) for j in self.judged])


def _pooled(pairs: list[tuple[float, Array]]) -> Array:
    total = sum(duration for duration, _ in pairs)
    return np.sqrt(sum(duration * rms ** 2 for duration, rms in pairs) / total)

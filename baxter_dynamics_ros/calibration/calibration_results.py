"""Results of a calibration."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..estimation.settings import PredictorSettings
from ..model.arrays import Array, Bools
from ..model.joints import JOINTS
from ..recordings.contact_intervals import Contact
from ..recordings.data_check import Notice
from ..recordings.playback import Lag

_BETTER = 0.01  # mean relative decrease of the left-out residual that makes a fit better


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


class Selection(NamedTuple):
    """Cross-validated residual after one more term."""

    term: str
    joints: tuple[int, ...]  # indices of the joints where it was kept
    rms: Array  # (7,) of recordings left out, with all terms kept so far [N m]
    active: Bools = np.zeros(0, dtype=bool)  # (p,) parameters kept so far


@dataclass(frozen=True, eq=False)
class Judged:
    """Fold result: residual of a recording or part, with a fit to the others."""

    name: str
    duration: float  # without contact [s]
    before: Array  # RMS (7,) of the residual with the initial settings, without contact [N m]
    after: Array  # ... with a fit to the other folds
    with_contact: 'Array | None' = None  # ... and contact included; None if there is none


@dataclass(frozen=True, eq=False)
class Calibration:
    """Result of a calibration."""

    arm: str  # 'right' or 'left'
    before: PredictorSettings  # initial, with the measured velocity lag
    after: PredictorSettings  # calibrated
    parameters: list[Fitted]
    steps: list[Selection]  # one per term that was tried; the first has no term
    judged: list[Judged]  # one per fold
    by_time: bool  # whether the folds are parts of one recording
    lag: 'Lag | None'  # measured velocity lag
    contacts: list[Contact]  # contact left out of the fit
    notices: tuple[Notice, ...]  # warnings about data and fit
    samples: int  # fitted samples
    duration: float  # of these [s]
    s1_range: tuple[float, float]  # range of s1 without outliers [rad]

    @property
    def rms_before(self) -> Array:
        """Return the RMS (7,) over all folds with the initial settings [N m]."""
        return self._pooled([one.before for one in self.judged])

    @property
    def rms_after(self) -> Array:
        """Return the RMS (7,) over all folds, calibrated, without contact [N m]."""
        return self._pooled([one.after for one in self.judged])

    @property
    def rms_with_contact(self) -> Array:
        """Return the RMS (7,) over all folds, calibrated, contact included [N m]."""
        return self._pooled([one.after if one.with_contact is None else one.with_contact
                             for one in self.judged])

    @property
    def better(self) -> bool:
        """Whether the left-out residual is smaller, by 1 % on the mean of the joints."""
        before, after = (np.maximum(rms, 1e-4) for rms in (self.rms_before, self.rms_after))
        return bool(np.log(after / before).mean() < np.log(1.0 - _BETTER))

    @property
    def summary(self) -> str:
        """Residuals before and after, in one line."""
        pairs = ', '.join(f'{joint} {before:.3f} to {after:.3f}' for joint, before, after in zip(
            JOINTS, self.rms_before, self.rms_after))
        return (f'residual on what was left out of the fit {"" if self.better else "not "}'
                f'reduced [N m]: {pairs}')

    def of_term(self, term: str) -> list[Fitted]:
        """Return the fitted quantities of a term."""
        return [one for one in self.parameters if one.term == term]

    def _pooled(self, rms: list[Array]) -> Array:
        return np.sqrt(np.average(np.square(rms), axis=0,
                                  weights=[one.duration for one in self.judged]))

"""Results of a calibration."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..estimation.settings import PredictorSettings
from ..model import Array, Bools, JOINTS
from ..recordings.data_check import Notice
from ..recordings.playback import Contact, Lag

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


class Judged(NamedTuple):
    """RMS (7,) of the residual of a fold, a recording or a part of one [N m]."""

    name: str
    duration: float  # without contact [s]
    before: Array  # with the initial settings, without contact
    after: Array  # with a fit to the other folds, without contact
    with_contact: Array  # the same, contact included


def pooled(folds: Sequence[Judged]) -> Judged:
    """Return the residuals of all folds together."""
    _, durations, *residuals = zip(*folds)
    return Judged('together', sum(durations), *(
        np.sqrt(np.average(np.square(rms), axis=0, weights=durations)) for rms in residuals))


@dataclass(frozen=True, eq=False)
class Calibration:
    """Result of a calibration."""

    before: PredictorSettings  # initial, with the measured velocity lag
    after: PredictorSettings  # calibrated
    parameters: list[Fitted]
    steps: list[Selection]  # one per term that was tried; the first has no term
    judged: list[Judged]  # one per fold
    fold: str  # 'recording', or 'part' of a single one
    lag: 'Lag | None'  # measured velocity lag
    contacts: list[Contact]  # contact left out of the fit
    notices: tuple[Notice, ...]  # warnings about data and fit
    samples: int  # fitted samples
    s1_range: tuple[float, float]  # range of s1 without outliers [rad]

    @cached_property
    def total(self) -> Judged:
        """Residuals of all folds together."""
        return pooled(self.judged)

    @property
    def better(self) -> bool:
        """Whether the left-out residual is smaller, by 1 % on the mean of the joints."""
        before, after = np.maximum([self.total.before, self.total.after], 1e-4)
        return bool(np.log(after / before).mean() < np.log(1.0 - _BETTER))

    @property
    def left_out(self) -> str:
        """Name of the data that judge the fit."""
        data = 'parts of the recording' if self.fold == 'part' else 'recordings'
        return f'{data} left out of the fit'

    @property
    def summary(self) -> str:
        """Residuals before and after, in one line."""
        pairs = ', '.join(f'{joint} {before:.3f} to {after:.3f}' for joint, before, after in zip(
            JOINTS, self.total.before, self.total.after))
        return (f'residual on {self.left_out} {"" if self.better else "not "}reduced [N m]: '
                + pairs)

    def of_term(self, term: str) -> list[Fitted]:
        """Return the fitted quantities of a term."""
        return [one for one in self.parameters if one.term == term]

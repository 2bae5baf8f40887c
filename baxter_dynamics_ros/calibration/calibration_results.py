"""Results of a calibration."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .term import Fitted
from ..model.arrays import Array, Bools
from ..recordings.contact_intervals import Contact
from ..recordings.data_check import DataCheck
from ..recordings.notices import Notice
from ..recordings.velocity_lag import Lag


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
    # ... with a fit to the other folds, contact included; None if there is no contact
    with_contact: 'Array | None' = None


@dataclass(frozen=True, eq=False)
class Calibration:
    """
    Result of a calibration.

    Attributes
    ----------
    arm : str
        'right' or 'left'.
    before, values : dict
        All settings of the predictor, initial and calibrated, both with the measured velocity lag.
    parameters : list of Fitted
        Fitted quantities.
    steps : list of Selection
        Cross-validated residual after each term that was tried; the first has no term.
    judged : list of Judged
        Results of the folds.
    by_time : bool
        Whether the folds are parts of one recording.
    lag : Lag or None
        Measured velocity lag.
    check : DataCheck or None
        Check of the data; None if there are too few samples.
    contacts : list of Contact
        Contact excluded from the fit.
    notices : tuple of Notice
        Warnings about data and fit.
    samples, duration : int, float
        Number of fitted samples and their duration [s].
    s1_range : tuple
        Range of s1 without outliers [rad].

    """

    arm: str
    before: dict[str, Any]
    values: dict[str, Any]
    parameters: list[Fitted]
    steps: list[Selection]
    judged: list[Judged]
    by_time: bool
    lag: 'Lag | None'
    check: 'DataCheck | None'
    contacts: list[Contact]
    notices: tuple[Notice, ...]
    samples: int
    duration: float
    s1_range: tuple[float, float]

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return the notices as lines of text."""
        return tuple(map(str, self.notices))

    @property
    def rms_before(self) -> Array:
        """Return the RMS (7,) over all folds with the initial settings [N m]."""
        return _pooled([(j.duration, j.before) for j in self.judged])

    @property
    def rms_after(self) -> Array:
        """Return the RMS (7,) over all folds, calibrated, without contact [N m]."""
        return _pooled([(j.duration, j.after) for j in self.judged])

    @property
    def rms_with_contact(self) -> Array:
        """Return the RMS (7,) over all folds, calibrated, contact included [N m]."""
        return _pooled([(j.duration, j.after if j.with_contact is None else j.with_contact)
                        for j in self.judged])

    def of_term(self, term: str) -> list[Fitted]:
        """Return the fitted quantities of a term."""
        return [one for one in self.parameters if one.term == term]


def _pooled(pairs: list[tuple[float, Array]]) -> Array:
    total = sum(duration for duration, _ in pairs)
    return np.sqrt(sum(duration * rms ** 2 for duration, rms in pairs) / total)

"""Results of a calibration: typed data for files, reports and people."""

from dataclasses import dataclass
from typing import Any, TYPE_CHECKING

import numpy as np

from .term import Fitted
from ..model.arrays import Array
from ..recordings.contact_intervals import Contact
from ..recordings.data_check import DataCheck
from ..recordings.notices import Notice
from ..recordings.velocity_lag import Lag

if TYPE_CHECKING:
    from .selection import Step


@dataclass(frozen=True, eq=False)
class Judged:
    """Fold result: a recording, or a part of one, predicted by a fit to the others."""

    name: str
    duration: float  # without contact [s]
    before: Array  # RMS (7,) of the residual with the settings before, without contact [N m]
    after: Array  # ... with what the others gave
    # ... with what the others gave, and contact not left out; None if there is no contact
    with_contact: 'Array | None' = None


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
        Cross-validated residual after each term that was tried; the first has no term.
    judged : list of Judged
        Result of each fold.
    by_time : bool
        Whether the folds are parts of one recording.
    lag : Lag or None
        Lag of the velocity.
    check : DataCheck or None
        Check of the data; None if there are too few samples.
    contacts : list of Contact
        What was left out of the fit as contact.
    notices : tuple of Notice
        What a reader should know.
    samples, duration : int, float
        Size of the data that were fitted [-, s].
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
        """Return the RMS (7,) over all folds, with the settings before [N m]."""
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
        """Return what was fitted of a term."""
        return [one for one in self.parameters if one.term == term]


def _pooled(pairs: list[tuple[float, Array]]) -> Array:
    total = sum(duration for duration, _ in pairs)
    return np.sqrt(sum(duration * rms ** 2 for duration, rms in pairs) / total)

"""Contact in a recording: intervals in which the residual exceeds errors of the model."""

from typing import NamedTuple

import numpy as np

from .playback import segments
from ..estimation.settings import ContactSettings
from ..model.arrays import Array, Bools
from ..model.joints import JOINTS, stops

MOST = 0.2  # share of a recording above which a large residual is an error of the model

_SHORTEST = 0.1  # duration for which the residual must exceed its limit [s]
_RELEASE = 0.25  # contact lasts while the residual exceeds this share of its limit
_MARGIN = 0.2  # excluded before and after, for the memory of the filter [s]


class Contact(NamedTuple):
    """One contact of one joint."""

    joint: str
    start: float  # since the beginning of the recording [s]
    end: float  # [s]
    peak: float  # largest residual [N m]
    at_stop: bool  # whether the joint is at the end of its range
    recording: str = ''

    def __str__(self) -> str:
        """Return joint, torque and time as text."""
        where = f'{self.joint} at its stop' if self.at_stop else self.joint
        return (f'{where}, {abs(self.peak):.0f} N m, from {self.start:.1f} to {self.end:.1f} s'
                + (f' of {self.recording}' if self.recording else ''))


def find_contacts(time: Array, residual: Array, q: Array, recording: str = '') -> list[Contact]:
    """
    Return the contacts in a recording, in the order of joints and times (n,) [s].

    Of residuals (n, 7) [N m] an offset does not matter; positions q are (n, 7) [rad].
    """
    if not len(time):
        return []
    residual = residual - np.median(residual, axis=0)
    near_stop = stops(q) != 0.0
    return [Contact(JOINTS[i], float(time[rows][0]), float(time[rows][-1]),
                    float(max(residual[rows, i], key=abs)), bool(np.median(near_stop[rows, i])),
                    recording)
            for i, limit in enumerate(ContactSettings.limit) for part in segments(time)
            for rows in _intervals(time, residual[:, i], part, limit)]


def contact_rows(time: Array, contacts: list[Contact]) -> Bools:
    """Return whether each sample (n,) belongs to a contact or its margin."""
    mask = np.zeros(len(time), dtype=bool)
    for contact in contacts:
        mask |= (time > contact.start - _MARGIN) & (time < contact.end + _MARGIN)
    return mask


def _intervals(time: Array, signal: Array, part: slice, limit: float) -> list[slice]:
    """Return the intervals of a segment that exceed the limit for long enough."""
    size = np.abs(signal[part])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], size > _RELEASE * limit, [0]])))
    found = []
    for start, end in zip(edges[::2], edges[1::2]):
        beyond = time[part][start:end][size[start:end] > limit]
        if len(beyond) and beyond[-1] - beyond[0] >= _SHORTEST:
            found.append(slice(part.start + start, part.start + end))
    return found

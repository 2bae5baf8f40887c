"""Contact in a recording: intervals in which the residual exceeds errors of the model."""

from typing import NamedTuple

import numpy as np

from .velocity_lag import segments
from ..estimation.settings import ContactSettings
from ..model.arrays import Array, Bools
from ..model.joints import JOINTS, N_JOINTS, POSITION_LOWER, POSITION_UPPER

MOST = 0.2  # share of a recording above which a large residual is an error of the model

_SHORTEST = 0.1  # duration for which the residual must exceed its limit [s]
_RELEASE = 0.25  # contact lasts while the residual exceeds this share of its limit
_MARGIN = 0.2  # excluded before and after, for the memory of the filter [s]
_STOP = 0.05  # distance from the limit of a joint at which it is at its stop [rad]


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
    Return the contacts in a recording, in the order of joints and times.

    Parameters
    ----------
    time : ndarray (n,)
        Time of each sample [s].
    residual : ndarray (n, 7)
        Measured - predicted effort [N m]; an offset does not matter.
    q : ndarray (n, 7)
        Position [rad].
    recording : str
        Name of the recording.

    """
    found = []
    for joint in range(N_JOINTS):
        signal = residual[:, joint] - np.median(residual[:, joint]) if len(time) else time
        for part in segments(time):
            limit = ContactSettings.limit[joint]
            for start, end in _intervals(time[part], np.abs(signal[part]), limit):
                rows = slice(part.start + start, part.start + end)
                peak = signal[rows][int(np.abs(signal[rows]).argmax())]
                middle = float(np.median(q[rows, joint]))
                at_stop = not (POSITION_LOWER[joint] + _STOP <= middle
                               <= POSITION_UPPER[joint] - _STOP)
                found.append(Contact(JOINTS[joint], float(time[rows.start]),
                                     float(time[rows.stop - 1]), float(peak), at_stop, recording))
    return found


def contact_rows(time: Array, contacts: list[Contact]) -> Bools:
    """Return whether each sample (n,) belongs to a contact or its margin."""
    mask = np.zeros(len(time), dtype=bool)
    for contact in contacts:
        mask |= (time > contact.start - _MARGIN) & (time < contact.end + _MARGIN)
    return mask


def _intervals(time: Array, size: Array, limit: float) -> list[tuple[int, int]]:
    """Return (first, last + 1) of each interval that exceeds the limit for long enough."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], size > _RELEASE * limit, [0]])))
    return [(start, end) for start, end in zip(edges[::2].tolist(), edges[1::2].tolist())
            if _time_beyond(time[start:end], size[start:end] > limit) >= _SHORTEST]


def _time_beyond(time: Array, beyond: Bools) -> float:
    if not beyond.any():
        return 0.0
    where = np.flatnonzero(beyond)
    return float(time[where[-1]] - time[where[0]])

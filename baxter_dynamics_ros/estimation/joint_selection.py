"""The door: one arm's joints out of a joint state, by name, or the reason why not."""

from collections.abc import Sequence

import numpy as np

from .events import Event
from ..model.arrays import Array, Indices
from ..model.joints import joint_names, N_JOINTS

# Beyond these a value cannot be a Baxter's (the limits are 3.1 rad, 4 rad/s and 50 N m): degrees,
# encoder ticks, or garbage.
PLAUSIBLE_POSITION = 2 * np.pi  # [rad]
PLAUSIBLE_VELOCITY = 40.0  # [rad/s]
PLAUSIBLE_EFFORT = 1000.0  # [N m]

_BOUNDS = np.array([[PLAUSIBLE_POSITION], [PLAUSIBLE_VELOCITY], [PLAUSIBLE_EFFORT]]).repeat(
    N_JOINTS, axis=1)
_MEMORY = 64  # layouts of messages remembered


class Intake:
    """
    Picks one arm's joints out of joint states.

    Parameters
    ----------
    side : str
        'right' or 'left'.

    """

    def __init__(self, side: str) -> None:
        self.side = side
        self.names = joint_names(side)
        # Names -> indices of the arm's joints, or an Event.
        self._layouts: dict[tuple[str, ...], Indices | Event] = {}

    def layout(self, names: Sequence[str]) -> Indices | Event:
        """
        Return where the arm's joints stand in ``names``.

        Returns
        -------
        ndarray (7,) of int, or Event
            NOT_THIS_ARM, INCOMPLETE_ARM or DUPLICATE_JOINT where they cannot be picked.

        """
        key = tuple(names)
        found = self._layouts.get(key)
        if found is None:
            if len(self._layouts) >= _MEMORY:
                self._layouts.clear()
            found = self._layouts[key] = self._find(key)
        return found

    def read(self, names: Sequence[str], position: Array, velocity: Array,
             effort: Array) -> tuple[Array, Array | None, Array | None] | Event:
        """
        Return the arm's position, velocity and effort.

        Parameters
        ----------
        names : sequence of str
            The message's joints.
        position, velocity, effort : ndarray
            As long as names; velocity and effort may be empty.

        Returns
        -------
        tuple (q, qd, effort), or Event
            Read-only arrays (7,) in joint order; qd and effort are None where the message has
            none.

        """
        layout = self.layout(names)
        if isinstance(layout, Event):
            return layout
        n = len(names)
        if len(position) != n or len(velocity) not in (0, n) or len(effort) not in (0, n):
            return Event.LENGTH_MISMATCH
        sample = np.zeros((3, N_JOINTS))
        sample[0] = position[layout]
        if len(velocity):
            sample[1] = velocity[layout]
        if len(effort):
            sample[2] = effort[layout]
        # Written so that NaN fails, too.
        if np.count_nonzero(np.abs(sample) <= _BOUNDS) < sample.size:
            return Event.IMPLAUSIBLE if np.isfinite(sample).all() else Event.NON_FINITE
        sample.setflags(write=False)
        return (sample[0], sample[1] if len(velocity) else None,
                sample[2] if len(effort) else None)

    def _find(self, names: tuple[str, ...]) -> Indices | Event:
        present = [name for name in names if name in self.names]
        if not present:
            return Event.NOT_THIS_ARM
        if len(set(present)) < len(present):
            return Event.DUPLICATE_JOINT
        if len(present) < N_JOINTS:
            return Event.INCOMPLETE_ARM
        return np.array([names.index(name) for name in self.names])

"""Selection of one arm's joints from joint states, by name."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from .events import Event
from ..model.arrays import Array, Indices
from ..model.joints import joint_names, N_JOINTS

# Largest plausible values; a Baxter's limits are 3.1 rad, 4 rad/s and 50 N m.
PLAUSIBLE_POSITION = 2 * np.pi  # [rad]
PLAUSIBLE_VELOCITY = 40.0  # [rad/s]
PLAUSIBLE_EFFORT = 1000.0  # [N m]

_BOUNDS = np.array([[PLAUSIBLE_POSITION], [PLAUSIBLE_VELOCITY], [PLAUSIBLE_EFFORT]]).repeat(
    N_JOINTS, axis=1)
_MEMORY = 64  # message layouts remembered


class JointSelector:
    """Selects the joints of one arm, 'right' or 'left', whose names have a prefix."""

    def __init__(self, side: str, prefix: str = '') -> None:
        self.side = side
        self.names = tuple(prefix + name for name in joint_names(side))  # in the messages
        # Of the newest message without a full set of the arm's joints; None if there was none.
        self.other_names: tuple[str, ...] | None = None
        self._find_once = lru_cache(_MEMORY)(self._find)

    def layout(self, names: Sequence[str]) -> Indices | Event:
        """Return the indices (7,) of the arm's joints in ``names``, or why there are none."""
        return self._find_once(tuple(names))

    def _find(self, names: tuple[str, ...]) -> Indices | Event:
        present = [name for name in names if name in self.names]
        if not present:
            return Event.NOT_THIS_ARM
        if len(set(present)) < len(present):
            return Event.DUPLICATE_JOINT
        if len(present) < N_JOINTS:
            return Event.INCOMPLETE_ARM
        return np.array([names.index(name) for name in self.names])

    def read(self, names: Sequence[str], position: Array, velocity: Array,
             effort: Array) -> tuple[Array, Array | None, Array | None] | Event:
        """
        Return position, velocity and effort, read-only (7,), or why they cannot be used.

        The arrays are as long as names; velocity and effort may be empty. NaN means "not
        available": a velocity or effort that is empty or contains NaN is returned as None. Values
        of other joints are ignored.
        """
        layout = self.layout(names)
        if isinstance(layout, Event):
            self.other_names = tuple(names)
            return layout
        n = len(names)
        if len(position) != n or len(velocity) not in (0, n) or len(effort) not in (0, n):
            return Event.LENGTH_MISMATCH
        sample = np.zeros((3, N_JOINTS))
        sample[0] = position[layout]
        has_velocity, has_effort = len(velocity) > 0, len(effort) > 0
        if has_velocity:
            sample[1] = velocity[layout]
        if has_effort:
            sample[2] = effort[layout]
        if np.count_nonzero(np.abs(sample) <= _BOUNDS) < sample.size:  # false for NaN
            if np.isnan(sample[0]).any() or np.isinf(sample).any():
                return Event.NON_FINITE
            if (np.abs(sample) > _BOUNDS)[~np.isnan(sample).any(axis=1)].any():
                return Event.IMPLAUSIBLE
            has_velocity &= not np.isnan(sample[1]).any()
            has_effort &= not np.isnan(sample[2]).any()
        sample.setflags(write=False)
        return (sample[0], sample[1] if has_velocity else None,
                sample[2] if has_effort else None)

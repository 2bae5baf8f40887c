"""Consistency check of measured velocity with measured position."""

from typing import NamedTuple

import numpy as np

from ..model.arrays import Array, Bools
from ..model.joints import JOINTS, N_JOINTS

WINDOW = 1.0  # over which velocity is integrated [s]
_CHECK_PERIOD = 0.5  # [s]; over less, a late message looks like a mismatch
# Allowed difference between position and the integral of velocity: velocity lags position by
# 14 ms on a Baxter, and by as much as messages are delayed where stamps are times of arrival.
_TOLERANCE = 0.03  # [rad]
_LAG = 0.02  # [s]; matters where a hard push throws a joint to and fro
_SHARE = 0.5  # of the motion
# Less motion than this does not show that velocity is right again.
_EVIDENCE = 0.1  # [rad]


class VelocityMismatch(NamedTuple):
    """Motion of a joint according to its position and according to its velocity."""

    joint: str
    moved: float  # range of the position [rad]
    integrated: float  # range of the integral of the velocity [rad]
    duration: float  # [s]


class VelocityCheck:
    """
    Compares the integral of velocity with the change of position over about a second.

    Attributes
    ----------
    mismatch : VelocityMismatch or None
        The largest mismatch found last; None while velocity and position agree.

    """

    def __init__(self) -> None:
        # Position, integral of velocity, and their difference [rad]; velocity [rad/s].
        self._sample = np.zeros((4, N_JOINTS))
        self._low = self._high = self._sample
        self._t, self._next_check = 0.0, _CHECK_PERIOD  # since the start of the window [s]
        self.reset()

    def reset(self) -> None:
        """Forget everything; velocity is used again."""
        self._wrong: Bools = np.zeros(N_JOINTS, dtype=bool)
        self.mismatch: VelocityMismatch | None = None
        self.restart()

    def restart(self) -> None:
        """Start a new window, as after a gap."""
        self._last: Array | None = None  # velocity [rad/s]

    @property
    def usable(self) -> bool:
        """Whether measured velocity can be used; true also while positions are frozen."""
        return not self._wrong.any()

    def update(self, dt: float, q: Array, qd: Array) -> bool:
        """
        Check a sample.

        Parameters
        ----------
        dt : float
            Time since the last sample [s]; of no effect after a restart.
        q, qd : ndarray (7,)
            Position [rad] and measured velocity [rad/s].

        Returns
        -------
        bool
            Whether measured velocity can be used.

        """
        sample = self._sample
        sample[0] = q
        if self._last is None:
            sample[1] = 0.0
        else:
            sample[1] += (0.5 * dt) * (qd + self._last)
            self._t += dt
        np.subtract(sample[1], q, out=sample[2])
        sample[3] = qd
        if self._last is None:
            self._begin_window()
        self._last = qd
        np.minimum(self._low, sample, out=self._low)
        np.maximum(self._high, sample, out=self._high)
        if self._t >= self._next_check:
            self._next_check = self._t + _CHECK_PERIOD
            self._compare()
            if self._t >= WINDOW:
                self._begin_window()
        return self.usable

    def _begin_window(self) -> None:
        self._t, self._next_check = 0.0, _CHECK_PERIOD
        self._low, self._high = self._sample.copy(), self._sample.copy()

    def _compare(self) -> None:
        moved, integrated, difference, change = self._high - self._low
        motion = np.maximum(moved, integrated)
        excess = difference - _TOLERANCE - _LAG * change - _SHARE * motion  # [rad]
        differs = excess > 0.0
        is_complete = self._t >= WINDOW
        if is_complete:
            self._wrong &= differs | (motion < _EVIDENCE)
        self._wrong |= differs & (moved > 0.0)
        if differs.any():
            i = int(excess.argmax())
            self.mismatch = VelocityMismatch(
                JOINTS[i], float(moved[i]), float(integrated[i]), self._t)
        elif is_complete and self.usable:
            self.mismatch = None

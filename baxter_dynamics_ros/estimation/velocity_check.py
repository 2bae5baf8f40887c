"""Consistency check of measured velocity with measured position."""

from typing import NamedTuple

import numpy as np

from ..model.arrays import Array, Bools
from ..model.joints import JOINTS, N_JOINTS

WINDOW = 1.0  # integration time of the velocity [s]
_CHECK_PERIOD = 0.5  # time between checks [s]; a late message looks like a mismatch if shorter
# Allowed difference between position and integrated velocity: velocity lags position by 14 ms on a
# Baxter, and stamps that are times of arrival add the transport delay.
_TOLERANCE = 0.03  # [rad]
_LAG = 0.02  # [s]; ... plus the change of velocity over this time, as in a hard push
_SHARE = 0.5  # ... plus this share of the motion
_EVIDENCE = 0.1  # motion needed to accept a velocity again [rad]


class VelocityMismatch(NamedTuple):
    """Motion of a joint according to measured position and to measured velocity."""

    joint: str
    moved: float  # range of the position [rad]
    integrated: float  # range of the integral of the velocity [rad]
    duration: float  # [s]


class VelocityCheck:
    """
    Compares integrated velocity with the change of position over about a second.

    Attributes
    ----------
    usable : bool
        Whether measured velocity can be used; also true while positions are frozen.
    mismatch : VelocityMismatch or None
        Largest mismatch of the last check that found one; None while velocity and position agree.

    """

    _t: float  # since the start of the window [s]
    _next_check: float  # [s]
    _low: Array
    _high: Array

    def __init__(self) -> None:
        # Position, integrated velocity, and their difference [rad]; velocity [rad/s].
        self._sample = np.zeros((4, N_JOINTS))
        self._begin_window()
        self.reset()

    def reset(self) -> None:
        """Forget everything; velocity is used again."""
        self._wrong: Bools = np.zeros(N_JOINTS, dtype=bool)
        self.usable = True
        self.mismatch: VelocityMismatch | None = None
        self.restart()

    def restart(self) -> None:
        """Start a new window, as after a gap."""
        self._last: Array | None = None  # velocity [rad/s]

    def update(self, dt: float, q: Array, qd: Array) -> bool:
        """
        Check a sample and return whether measured velocity can be used.

        Parameters
        ----------
        dt : float
            Time since the last sample [s]; ignored after a restart.
        q, qd : ndarray (7,)
            Position [rad] and measured velocity [rad/s].

        """
        sample, last, self._last = self._sample, self._last, qd
        integrated = 0.0 if last is None else sample[1] + (0.5 * dt) * (qd + last)
        sample[0], sample[1], sample[3] = q, integrated, qd
        np.subtract(sample[1], q, out=sample[2])
        if last is None:
            self._begin_window()
        else:
            self._t += dt
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
        self.usable = not self._wrong.any()
        if differs.any():
            i = int(excess.argmax())
            self.mismatch = VelocityMismatch(
                JOINTS[i], float(moved[i]), float(integrated[i]), self._t)
        elif is_complete and self.usable:
            self.mismatch = None

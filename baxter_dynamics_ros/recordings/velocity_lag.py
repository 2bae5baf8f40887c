"""
Lag and scale of the measured velocity relative to the position.

A velocity that is ``lag`` seconds old integrates to less than the change of position by ``lag``
times the change of velocity: a straight line, fitted over intervals of one second, in which
noise and quantisation hardly matter. The slope of the change of position over the integrated
velocity is the scale: 1 if velocities are in rad/s and the stamps have the true period.
"""

from typing import NamedTuple

import numpy as np

from ..model.arrays import Array
from ..model.joints import N_JOINTS

TRAVEL = 0.05  # range of position within which a joint counts as at rest [rad]

_INTERVAL = 1.0  # of the integration of velocity [s]
_SLOPE = 0.02  # half the interval of the slope of position [s]
_BREAK = 0.15  # time between samples that ends a segment [s]


class Lag(NamedTuple):
    """Lag of the velocity."""

    value: float  # [s]
    uncertainty: float  # standard error, from the differences between joints [s]
    per_joint: Array  # (7,) [s]; NaN for a joint that does not move


def segments(time: Array) -> list[slice]:
    """Return the slices between gaps of a time axis (n,) [s]."""
    breaks = np.flatnonzero(np.abs(np.diff(time)) > _BREAK) + 1
    return [slice(*pair) for pair in zip([0, *breaks], [*breaks, len(time)])]


class VelocitySums:
    """Running sums for lag and scale over any number of recordings."""

    def __init__(self) -> None:
        self._lag = np.zeros((2, N_JOINTS))  # shortfall * change of velocity, and its square
        self._scale = np.zeros((2, N_JOINTS))  # travel * integral, and its square

    def add(self, time: Array, q: Array, qd: Array) -> None:
        """
        Add consecutive samples.

        Parameters
        ----------
        time : ndarray (n,)
            Stamps [s]; gaps divide the samples.
        q, qd : ndarray (n, 7)
            Position [rad] and measured velocity [rad/s] of the same messages.

        """
        for part in segments(time):
            self._add_segment(time[part], q[part], qd[part])

    def _add_segment(self, t: Array, q: Array, qd: Array) -> None:
        period = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
        if period <= 0.0 or len(t) * period < 3 * _INTERVAL or not np.isfinite(qd).all():
            return
        n = max(round(_INTERVAL / period), 1)
        step = 0.5 * np.diff(t)[:, None] * (qd[1:] + qd[:-1])
        integral = np.concatenate([np.zeros((1, N_JOINTS)), np.cumsum(step, axis=0)])
        k = max(round(_SLOPE / period), 2)
        velocity = (q[2 * k:] - q[:-2 * k]) / (t[2 * k:] - t[:-2 * k])[:, None]
        moves = np.ptp(q, axis=0) > TRAVEL
        shortfall, change = (_centered(x[n:] - x[:-n]) * moves
                             for x in ((q - integral)[k:-k], velocity))
        self._lag += np.sum([shortfall * change, change * change], axis=1)
        travel, integrated = (_centered(x[n:] - x[:-n]) * moves for x in (q, integral))
        self._scale += np.sum([travel * integrated, integrated * integrated], axis=1)

    def lag(self) -> 'Lag | None':
        """Return the lag; None if no joint moved or no velocity was measured."""
        product, square = self._lag
        if not square.any():
            return None
        moves = square > 1e-3 * square.max()
        lags = np.full(N_JOINTS, np.nan)
        lags[moves] = product[moves] / square[moves]
        value = float(np.median(lags[moves]))
        spread = float(np.std(lags[moves], ddof=1)) if moves.sum() > 1 else abs(value)
        return Lag(value, spread / float(np.sqrt(moves.sum())), lags)

    def scale(self) -> float:
        """Return travel over integrated velocity, as median over the joints; NaN if unknown."""
        product, square = self._scale
        moves = square > 1e-3 * square.max()
        return float(np.median(product[moves] / square[moves])) if square.any() else np.nan


def _centered(values: Array) -> Array:
    return values - values.mean(0)

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


def velocity_sums(time: Array, q: Array, qd: Array) -> Array:
    """
    Return the sums for :func:`lag_and_scale`, (2, 2, 7), of some consecutive messages.

    They are time (n,) [s], position and measured velocity (n, 7); sums of parts are added.
    """
    sums = np.zeros((2, 2, N_JOINTS))  # lag, scale; sums of y x and x^2 of their straight lines
    for segment in segments(time):
        sums += _sums(time[segment], q[segment], qd[segment])
    return sums


def lag_and_scale(sums: Array) -> tuple['Lag | None', float]:
    """Return the lag, and travel over integrated velocity; None and NaN if no joint moved."""
    lags, scales = map(_slopes, *sums.swapaxes(0, 1))
    scale = float(np.nanmedian(scales)) if np.isfinite(scales).any() else np.nan
    known = lags[np.isfinite(lags)]
    if not len(known):
        return None, scale
    value = float(np.median(known))
    spread = float(np.std(known, ddof=1)) if len(known) > 1 else abs(value)
    return Lag(value, spread / float(np.sqrt(len(known))), lags), scale


def _sums(t: Array, q: Array, qd: Array) -> 'Array | float':
    """Return the sums for lag and scale, (2, 2, 7), or zero for too short a segment."""
    period = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    if period <= 0.0 or len(t) * period < 3 * _INTERVAL or not np.isfinite(qd).all():
        return 0.0
    n = max(round(_INTERVAL / period), 1)
    k = max(round(_SLOPE / period), 2)
    steps = 0.5 * np.diff(t)[:, None] * (qd[1:] + qd[:-1])
    integral = np.cumsum(np.concatenate([np.zeros((1, N_JOINTS)), steps]), axis=0)
    velocity = (q[2 * k:] - q[:-2 * k]) / (t[2 * k:] - t[:-2 * k])[:, None]
    moves = np.ptp(q, axis=0) > TRAVEL

    def change(values: Array) -> Array:
        """Return changes over the interval, less their mean; zero at rest."""
        changes = values[n:] - values[:-n]
        return (changes - changes.mean(0)) * moves

    lines = ((velocity, (q - integral)[k:-k]), (integral, q))  # x, y
    return np.array([np.sum([change(y) * change(x), change(x) ** 2], axis=1) for x, y in lines])


def _slopes(product: Array, square: Array) -> Array:
    """Return the slope for each joint (7,), NaN for a joint that hardly moves."""
    moves = square > 1e-3 * square.max()
    return np.divide(product, square, out=np.full(N_JOINTS, np.nan), where=moves)

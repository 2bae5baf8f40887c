r"""
How far the measured velocity lags the position.

If the velocity is that of ``lag`` seconds ago, its integral falls short of the change of position
by ``lag`` times the change of velocity. That is a straight line, fitted over intervals of a
second, in which neither noise nor quanta matter much.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from .fit_data import Motion
from ..model.arrays import Array

_INTERVAL = 1.0  # over which the velocity is integrated [s]
_SLOPE = 0.02  # on either side, over which the position's slope is taken [s]


class Lag(NamedTuple):
    """The velocity's lag."""

    value: float  # [s]
    uncertainty: float  # standard error, from how much the joints differ [s]
    per_joint: Array  # (7,) [s]; NaN for a joint that does not move


def velocity_lag(motions: Iterable[Motion]) -> 'Lag | None':
    """
    Measure the lag of the velocity.

    Parameters
    ----------
    motions : sequence of Motion
        The recordings.

    Returns
    -------
    Lag or None
        None where no joint moves, or no velocity is measured.

    """
    product, square = np.zeros(7), np.zeros(7)
    for motion in motions:
        n = max(round(_INTERVAL / motion.period), 1)
        for segment in motion.segments:
            t, q, qd = motion.time[segment], motion.newest_q[segment], motion.newest_qd[segment]
            if len(t) < 3 * n or not np.isfinite(qd).all():
                continue
            step = 0.5 * np.diff(t)[:, None] * (qd[1:] + qd[:-1])
            shortfall = q - np.concatenate([np.zeros((1, 7)), np.cumsum(step, axis=0)])
            k = max(round(_SLOPE / motion.period), 2)
            velocity = (q[2 * k:] - q[:-2 * k]) / (t[2 * k:] - t[:-2 * k])[:, None]
            shortfall, change = (x[n:] - x[:-n] for x in (shortfall[k:-k], velocity))
            shortfall, change = shortfall - shortfall.mean(0), change - change.mean(0)
            product += (shortfall * change).sum(0)
            square += (change * change).sum(0)
    moves = square > 1e-3 * square.max(initial=0.0)
    if not square.any():
        return None
    lags = np.full(7, np.nan)
    lags[moves] = product[moves] / square[moves]
    value = float(np.median(lags[moves]))
    spread = float(np.std(lags[moves], ddof=1)) if moves.sum() > 1 else value
    return Lag(value, spread / np.sqrt(moves.sum()), lags)

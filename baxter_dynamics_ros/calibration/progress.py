"""How much of the motion that a calibration needs has been seen."""

from typing import NamedTuple

import numpy as np

from ..model.arrays import Array
from ..model.joints import JOINTS, N_JOINTS

_STEP = 0.2  # time between the positions that are compared, long for their quantisation [s]
_DURATION = 20.0  # for which acceleration must last [s]

# Motion that identifies the parameters of a joint, measured on recordings and on the exciting
# trajectory: quantity, its minimum, and the advice for joints that lack it.
_REQUIRED = (
    ('range', 0.8, 'move {} through more of the range'),  # [rad]
    ('forward', 0.2, 'move {} faster in the positive direction'),  # [rad/s]
    ('backward', 0.2, 'move {} faster in the negative direction'),  # [rad/s]
    ('acceleration', 0.15, 'accelerate {} more'),  # RMS over _DURATION [rad/s^2]
)


class Progress(NamedTuple):
    """Motion seen so far."""

    seen: Array  # (7,) share of the required motion, 0 to 1
    advice: str  # the motion that is missing most, in one line


def progress(time: Array, q: Array) -> Progress:
    """
    Return how much of the required motion some positions show.

    Speed and acceleration are those of the positions, because measured velocities have too much
    noise on some arms.

    Parameters
    ----------
    time : ndarray (n,)
        Increasing times [s].
    q : ndarray (n, 7)
        Positions [rad].

    """
    shares = np.zeros((len(_REQUIRED), N_JOINTS))
    stride = max(round(_STEP / float(np.median(np.diff(time)))), 1) if len(time) > 1 else 1
    t, q = time[::stride], q[::stride]
    if len(t) > 2:
        speed = np.diff(q, axis=0) / np.diff(t)[:, None]
        square = np.diff(speed, axis=0) ** 2 / (0.5 * (t[2:] - t[:-2]))[:, None]
        shown = np.stack([np.ptp(q, axis=0), speed.max(0), -speed.min(0),
                          np.sqrt(square.sum(0) / _DURATION)])
        shares = np.clip(shown / np.array([[least] for _, least, _ in _REQUIRED]), 0.0, 1.0)
    return Progress(shares.min(0), _advice(shares))


def _advice(shares: Array) -> str:
    worst = int(np.argmin(shares.mean(1)))
    lacking = [JOINTS[i] for i in np.flatnonzero(shares[worst] < 1.0)]
    if not lacking:
        return 'all joints have moved enough; further motion improves the result'
    return _REQUIRED[worst][2].format(', '.join(lacking))

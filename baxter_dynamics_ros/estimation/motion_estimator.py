"""One instant's position, velocity, acceleration and effort out of a noisy, lagging stream."""

from typing import NamedTuple

import numpy as np

from .butterworth import ButterworthDerivative
from .delay_line import DelayLine
from .slope import PositionSlope
from ..model.arrays import Array
from ..model.joints import N_JOINTS


class Motion(NamedTuple):
    """The arm's motion at one instant; arrays (7,) in joint order."""

    delay: float  # how far before the newest sample the instant is [s]
    q: Array  # [rad]
    qd: Array  # [rad/s]
    qdd: Array  # [rad/s^2]
    effort: 'Array | None'  # measured [N m]


class MotionEstimator:
    """
    Estimate accelerations, and align everything to the instant they are for.

    The robot's velocity lags its position and effort by ``velocity_lag`` (14 ms measured), and
    the filter adds its own delay (45 ms at 5 Hz). Where ``align`` is true, position and effort
    are looked up that much earlier, so that all four belong to one instant. Without it the
    newest position, velocity and effort go with an acceleration that lags.

    Parameters
    ----------
    cutoff : float
        Cut-off frequency of the derivative [Hz].
    velocity_lag : float
        How far the measured velocity lags position and effort [s].
    align : bool
        Whether to align in time.

    Attributes
    ----------
    cutoff : float
        Cut-off frequency of the derivative [Hz].
    delay : float
        How far before the newest sample the estimate is, measured velocities given [s].
    settling_time : float
        How long after a reset estimates are withheld [s].
    velocity : ndarray (7,)
        The newest velocity, as measured, or the slope of the positions [rad/s].
    velocity_lag : float
        How far that lags the newest position [s].

    """

    def __init__(self, cutoff: float, velocity_lag: float, align: bool) -> None:
        self.cutoff = cutoff
        self._filter = ButterworthDerivative(cutoff)
        self._slope = PositionSlope()
        self._history = DelayLine()
        self._measured_lag = velocity_lag
        self._align = align
        self._t: float | None = None  # of the newest sample, since the last reset [s]
        self.velocity: Array = np.zeros(N_JOINTS)
        self.velocity_lag = velocity_lag
        self.delay = velocity_lag + self._filter.delay if align else 0.0
        self.settling_time = max(self._filter.settling_time, self.delay)

    def reset(self) -> None:
        """Forget the stream."""
        self._t = None
        self._slope.reset()
        self._history.reset()

    def update(self, dt: float, q: Array, qd: Array | None,
               effort: Array | None) -> 'Motion | None':
        """
        Take the next sample.

        Parameters
        ----------
        dt : float
            Time since the last sample [s]; of no effect on the first.
        q : ndarray (7,)
            Position [rad].
        qd, effort : ndarray (7,) or None
            Velocity [rad/s] and effort [N m].

        Returns
        -------
        Motion or None
            None while the filter settles and where dt is zero.

        """
        before = self._t
        self._t = t = 0.0 if before is None else before + dt
        self.velocity_lag = self._measured_lag
        if qd is None:
            qd = self._slope.update(t, q)
            self.velocity_lag = self._slope.lag
        self.velocity = qd
        if before is None:
            self._filter.reset(qd)
        else:
            self._filter.update(qd, dt)
        if not self._align:
            motion = Motion(0.0, q, qd, self._filter.derivative, effort)
        else:
            delay = self.velocity_lag + self._filter.delay
            self._history.append(t, q, effort)
            then = self._history.at(t - delay)
            if then is None:
                return None
            motion = Motion(delay, then[0], self._filter.value, self._filter.derivative, then[1])
        return motion if dt > 0.0 and t >= self.settling_time else None

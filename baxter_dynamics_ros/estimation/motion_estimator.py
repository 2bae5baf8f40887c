"""Acceleration estimate, and time alignment of position, velocity and effort."""

from typing import NamedTuple

from .butterworth import ButterworthDerivative
from .delay_line import DelayLine
from .slope import PositionSlope
from ..model.arrays import Array


class AcceleratedMotion(NamedTuple):
    """Position, velocity, acceleration and effort at one instant; arrays (7,) in joint order."""

    delay: float  # time from the instant to the newest sample [s]
    q: Array  # [rad]
    qd: Array  # [rad/s]
    qdd: Array  # [rad/s^2]
    effort: 'Array | None'  # measured [N m]


class MotionEstimate(NamedTuple):
    """State at the instant of the newest velocity, and motion at that of the acceleration."""

    t: float  # instant of the velocity, relative to the start of the stream [s]
    lag: float  # time from that instant to the newest sample [s]
    q: 'Array | None'  # (7,) [rad]; None if the instant is before the first sample
    qd: Array  # (7,) [rad/s]
    effort: 'Array | None'  # measured (7,) [N m]
    accelerated: 'AcceleratedMotion | None'  # None while the filter settles and if dt is zero


class MotionEstimator:
    """
    Estimates the acceleration and aligns all signals to one instant.

    The robot's velocity lags position and effort by ``velocity_lag`` (14 ms measured), and the
    filter adds its own delay (45 ms at 5 Hz). One buffer of position and effort is read at both
    delays. Without ``align`` the newest position, velocity and effort are combined with the
    delayed acceleration.

    Parameters
    ----------
    cutoff : float
        Cut-off frequency of the derivative [Hz].
    velocity_lag : float
        Lag of the measured velocity behind position and effort [s].
    align : bool
        Whether to align in time.

    Attributes
    ----------
    cutoff : float
        Cut-off frequency of the derivative [Hz].
    velocity_lag : float
        Lag of the measured velocity behind position and effort [s].
    delay : float
        Time from the instant of the estimate to the newest sample, if velocity is measured [s].
    settling_time : float
        Time after a reset for which estimates are withheld [s].

    """

    def __init__(self, cutoff: float, velocity_lag: float, align: bool) -> None:
        self._slope = PositionSlope()
        self._history = DelayLine()
        self._t: float | None = None  # time of the newest sample since the last reset [s]
        self.configure(cutoff, velocity_lag, align)

    def configure(self, cutoff: float, velocity_lag: float, align: bool) -> None:
        """Change the filter, which settles again; the buffered samples stay."""
        self.cutoff = cutoff
        self.velocity_lag = velocity_lag
        self._align = align
        self._filter = ButterworthDerivative(cutoff)
        self._start: float | None = None  # time at which the filter was started [s]
        self.delay = velocity_lag + self._filter.delay if align else 0.0
        self.settling_time = max(self._filter.settling_time, self.delay)

    def reset(self) -> None:
        """Forget the stream."""
        self._t = self._start = None
        self._slope.reset()
        self._history.reset()

    def update(self, dt: float, q: Array, qd: Array | None,
               effort: Array | None) -> MotionEstimate:
        """
        Process the next sample.

        Parameters
        ----------
        dt : float
            Time since the last sample [s]; ignored for the first.
        q : ndarray (7,)
            Position [rad].
        qd, effort : ndarray (7,) or None
            Velocity [rad/s] and effort [N m].

        """
        self._t = t = 0.0 if self._t is None else self._t + dt
        lag = self.velocity_lag
        if qd is None:
            qd = self._slope.update(t, q)
            lag = self._slope.lag
        if self._start is None:
            self._start = t
            self._filter.reset(qd)
        else:
            self._filter.update(qd, dt)
        self._history.append(t, q, effort)
        settled = dt > 0.0 and t - self._start >= self.settling_time
        then = self._history.at(t - lag) or (None, None)
        return MotionEstimate(
            t - lag, lag, then[0], qd, then[1],
            self._accelerated(t, lag, q, qd, effort) if settled else None)

    def _accelerated(self, t: float, lag: float, q: Array, qd: Array,
                     effort: Array | None) -> AcceleratedMotion | None:
        if not self._align:
            return AcceleratedMotion(0.0, q, qd, self._filter.derivative, effort)
        delay = lag + self._filter.delay
        then = self._history.at(t - delay)
        if then is None:
            return None
        return AcceleratedMotion(
            delay, then[0], self._filter.value, self._filter.derivative, then[1])

"""Acceleration estimate, and time alignment of position, velocity and effort."""

from typing import NamedTuple

from .butterworth import ButterworthDerivative
from .delay_line import DelayLine
from .settings import MATCHED, PredictorSettings
from .slope import PositionSlope
from ..model.arrays import Array


class AcceleratedMotion(NamedTuple):
    """Position, velocity, acceleration and effort at one instant; arrays (7,) in joint order."""

    delay: float  # time from the instant to the newest sample [s]
    q: Array  # [rad]
    qd: Array  # [rad/s]
    qdd: Array  # [rad/s^2]
    effort: 'Array | None'  # measured [N m]; None if missing or its filter settles


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

    Measured velocity lags position and effort, and the filter that differentiates it adds its own
    delay. One buffer of position and effort is read at both delays. With the effort band
    'matched', effort passes through the same filter as velocity, at the same instant: both sides
    of the residual then have one band. It settles again after effort was missing. Without
    ``align`` the newest position, velocity and effort are combined with the delayed acceleration.

    Parameters
    ----------
    settings : PredictorSettings
        Settings ``acceleration``, ``align`` and ``effort_band``.

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

    def __init__(self, settings: PredictorSettings) -> None:
        self._slope = PositionSlope()
        self._history = DelayLine()
        self._t: float | None = None  # time of the newest sample since the last reset [s]
        self.configure(settings)

    def configure(self, settings: PredictorSettings) -> None:
        """Change the filters, which settle again; the buffered samples stay."""
        self.cutoff = settings.acceleration.cutoff
        self.velocity_lag = settings.acceleration.velocity_lag
        self._align = settings.align
        self._is_matched = settings.align and settings.effort_band == MATCHED
        self._velocity = _SettlingFilter(self.cutoff)
        self._effort = _SettlingFilter(self.cutoff)
        self._filter_delay = self._velocity.delay
        self.delay = self.velocity_lag + self._filter_delay if self._align else 0.0
        self.settling_time = max(self._velocity.settling_time, self.delay)

    def reset(self) -> None:
        """Forget the stream."""
        self._t = self._velocity.start = self._effort.start = None
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
        self._history.append(t, q, effort)
        self._velocity.add(t, dt, qd)
        then = self._history.at(max(t - lag, 0.0)) or (None, None)
        if self._is_matched:
            self._effort.add(t, dt, then[1])
        if t < lag:
            then = None, None
        settled = dt > 0.0 and self._velocity.runs_for(t, self.settling_time)
        return MotionEstimate(t - lag, lag, then[0], qd, then[1],
                              self._accelerated(t, lag, q, qd, effort) if settled else None)

    def _accelerated(self, t: float, lag: float, q: Array, qd: Array,
                     effort: Array | None) -> AcceleratedMotion | None:
        if not self._align:
            return AcceleratedMotion(0.0, q, qd, self._velocity.derivative, effort)
        delay = lag + self._filter_delay
        then = self._history.at(t - delay)
        if then is None:
            return None
        measured = then[1]
        if self._is_matched:
            settled = self._effort.runs_for(t, self.settling_time)
            measured = self._effort.value if settled else None
        return AcceleratedMotion(
            delay, then[0], self._velocity.value, self._velocity.derivative, measured)


class _SettlingFilter(ButterworthDerivative):
    """Filter that starts with the first value and again after a missing one."""

    start: float | None = None  # time at which it was started [s]

    def add(self, t: float, dt: float, u: Array | None) -> None:
        """Process the value at t [s], dt [s] after the last one."""
        if u is None:
            self.start = None
        elif self.start is None:
            self.start = t
            self.reset(u)
        else:
            self.update(u, dt)

    def runs_for(self, t: float, duration: float) -> bool:
        """Return whether it has run for a duration [s]."""
        return self.start is not None and t - self.start >= duration

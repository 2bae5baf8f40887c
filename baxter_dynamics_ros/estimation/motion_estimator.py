"""Acceleration estimate, and time alignment of position, velocity and effort."""

from bisect import bisect_left, bisect_right
from functools import lru_cache
from math import log, pi, sqrt
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from .continuity import SHORTEST_PERIOD
from .settings import MATCHED, PredictorSettings
from ..model import Array, Presliding

_DAMPING = 1 / sqrt(2)  # of a second-order Butterworth filter
_RETENTION = 0.7  # longer than the largest configurable delay [s]
_MAX_SAMPLES = 1024  # bounds memory if stamps hardly advance
_SLOPE_TIME = 0.033  # 30 ms plus a tenth, so that jitter never changes the sample count [s]
_TIME = itemgetter(0)


class Estimate(NamedTuple):
    """Motion and measured effort of the arm at one instant; read-only (7,) in joint order."""

    stamp_ns: Any  # the instant [ns], on the clock of the stamps: int, or an array in a batch
    q: Array  # position [rad]
    qd: Array  # velocity [rad/s]
    qdd: Array  # acceleration [rad/s^2]
    measured: 'Array | None'  # effort in the band of the acceleration, or raw [N m]
    presliding: Array  # Dahl's state [-]


class MotionUpdate(NamedTuple):
    """State at the instant of the newest velocity, and estimate at that of the acceleration."""

    stamp_ns: int  # instant of the velocity [ns]
    t: float  # the same, relative to the start of the stream [s]
    q: 'Array | None'  # (7,) [rad]; None if the instant is before the first sample
    qd: Array  # (7,) [rad/s]
    effort: 'Array | None'  # measured (7,) [N m]
    estimate: 'Estimate | None'  # None while the filter settles and if dt is zero


class MotionEstimator:
    """
    Estimates the acceleration and aligns all signals to one instant.

    Measured velocity lags position and effort, and the filter that differentiates it adds its own
    delay. One buffer of position and effort is read at both delays. With the effort band
    'matched', effort passes through the same filter as velocity, at the same instant: both sides
    of the residual then have one band. It settles again after effort was missing. Without
    ``align`` the newest position, velocity and effort are combined with the delayed acceleration.
    """

    def __init__(self, settings: PredictorSettings) -> None:
        self.dahl = Presliding(settings.model.effort_model.presliding_length)
        self.configure(settings)
        self.reset()

    def configure(self, settings: PredictorSettings) -> None:
        """Change the filters, which settle again; the buffered samples stay."""
        self.velocity_lag = settings.acceleration.velocity_lag  # behind position and effort [s]
        cutoff = settings.acceleration.cutoff
        self._align = settings.align
        self._is_matched = settings.align and settings.effort_band == MATCHED
        self._velocity, self._effort = ButterworthDerivative(cutoff), ButterworthDerivative(cutoff)
        # Time from the instant of the estimate to the newest sample, if velocity is measured [s].
        self.delay = self.velocity_lag + self._velocity.delay if self._align else 0.0
        # Time after a reset for which estimates are withheld [s].
        self.settling_time = max(self._velocity.settling_time, self.delay)

    def reset(self) -> None:
        """Forget the stream."""
        self._t: float | None = None  # time of the newest sample since the stream began [s]
        self._velocity.start = self._effort.start = None
        self._history = History()
        self.dahl.reset()

    def update(self, stamp_ns: int, dt: float, q: Array, qd: Array | None,
               effort: Array | None) -> MotionUpdate:
        """
        Process position q [rad], velocity qd [rad/s] and effort [N m], (7,) each, of a stamp [ns].

        They were sampled dt [s] after the last ones; dt is ignored for the first. Without velocity
        the slope of the positions takes its place.
        """
        self._t = t = 0.0 if self._t is None else self._t + dt
        lag = self.velocity_lag
        self._history.append(t, q, effort)
        if qd is None:
            qd, lag = self._history.slope()
        self._velocity.update(t, dt, qd)
        then = self._history.at(max(t - lag, 0.0)) or (None, None)
        if self._is_matched:
            self._effort.update(t, dt, then[1])
        if t < lag:
            then = None, None
        settled = dt > 0.0 and self._velocity.runs_for(t, self.settling_time)
        return MotionUpdate(stamp_ns - round(lag * 1e9), t - lag, then[0], qd, then[1],
                            self._estimate(stamp_ns, t, lag, (q, qd, effort)) if settled
                            else None)

    def _estimate(self, stamp_ns: int, t: float, lag: float,
                  newest: tuple[Array, Array, Array | None]) -> Estimate | None:
        q, qd, effort = newest
        qdd, delay = self._velocity.derivative, 0.0
        if self._align:
            delay = lag + self._velocity.delay
            then = self._history.at(t - delay)
            if then is None:
                return None
            (q, effort), qd = then, self._velocity.value
            if self._is_matched:
                settled = self._effort.runs_for(t, self.settling_time)
                effort = self._effort.value if settled else None
        arrays = q, qd, qdd, effort, self.dahl.update(q)
        for array in arrays:
            if array is not None:
                array.setflags(write=False)
        return Estimate(stamp_ns - round(delay * 1e9), *arrays)


class ButterworthDerivative:
    r"""
    Low-pass filter and derivative of u: x'' = w^2 (u - x) - 2 zeta w x'.

    Integrated by the trapezoidal rule with the true time step of every sample, which is stable
    for any step. x follows u, and x' follows du/dt, with the same delay. The filter starts at rest
    at the first value, and again after a missing one.
    """

    def __init__(self, cutoff: float) -> None:
        self._w = 2 * pi * cutoff  # [rad/s]
        self.delay = 2 * _DAMPING / self._w  # group delay of x and of x' at low frequency [s]
        # Time in which the envelope of the initial error decays to 1 % [s].
        self.settling_time = log(100.0) / (_DAMPING * self._w)
        self.start: float | None = None  # time of the first value [s]

    def update(self, t: float, dt: float, u: Array | None) -> None:
        """
        Process u (...) at t [s], dt [s] after the last one.

        If dt is zero, the state stays and the next step starts from u.
        """
        if u is None:
            self.start = None
            return
        if self.start is None:
            self.start = t
            # (..., 3): x', u - x at the previous sample, u - x at the newest.
            self._state: Array = np.zeros(np.shape(u) + (3,))
            self.value = u  # x
            self.derivative: Array = self._state[..., 0]  # x', in u's unit per second
            return
        self._state[..., 2] = u - self.value
        # x', u - x, and the change of x
        self._state = self._state.dot(_trapezoid(self._w, dt))
        self.derivative = self._state[..., 0]
        self.value = self.value + self._state[..., 2]

    def runs_for(self, t: float, duration: float) -> bool:
        """Return whether it has run for a duration [s] at t [s]."""
        return self.start is not None and t - self.start >= duration


@lru_cache(maxsize=2)  # velocity and effort are filtered alike, mostly in equal steps
def _trapezoid(w: float, dt: float) -> Array:
    """Return the matrix (3, 3) that multiplies the filter's state from the right in dt [s]."""
    a = dt * w * _DAMPING
    b = (dt * w) ** 2 / 4
    c = dt * w ** 2 / 2
    return np.array([[1 - a - b, -dt, dt], [c, -b, b], [c, 1 + a, b]]) / (1 + a + b)


class History:
    """Recent positions and efforts over time, interpolated at earlier times."""

    def __init__(self) -> None:
        # Time [s], position (7,) [rad], effort (7,) [N m].
        self._samples: list[tuple[float, Array, Array | None]] = []

    def append(self, t: float, q: Array, effort: Array | None) -> None:
        """
        Add position q (7,) [rad] and effort (7,) [N m] or None at time t [s].

        Times must not decrease; a sample with the last time replaces the last sample.
        """
        samples = self._samples
        if samples and samples[-1][0] == t:
            samples.pop()
        samples.append((t, q, effort))
        while len(samples) > _MAX_SAMPLES or len(samples) > 1 and samples[1][0] <= t - _RETENTION:
            del samples[0]

    def at(self, t: float) -> tuple[Array, Array | None] | None:
        """
        Return position and effort (7,) at t [s], at most the last time, by linear interpolation.

        None if t is before the first sample. The effort is None if a neighbouring sample has none.
        """
        samples = self._samples
        after = bisect_right(samples, t, key=_TIME)
        if after == 0:
            return None
        t0, q0, effort0 = samples[after - 1]
        if t == t0 or after == len(samples):
            return q0, effort0
        t1, q1, effort1 = samples[after]
        w = np.array((t - t0) / (t1 - t0))  # multiplies faster than a float
        q = q0 + w * (q1 - q0)
        if effort0 is None or effort1 is None:
            return q, None
        return q, effort0 + w * (effort1 - effort0)

    def slope(self) -> tuple[Array, float]:
        """
        Return the least-squares slope of the newest positions, (7,) [rad/s], and its lag [s].

        The slope spans more than 33 ms at low rates and for bursts, because a slope over less than
        SHORTEST_PERIOD is meaningless; it is zero as long as there is no such span.
        """
        samples = self._samples
        t, q, _ = samples[-1]
        earlier = bisect_right(samples, t - SHORTEST_PERIOD, key=_TIME)
        if earlier == 0:
            return np.zeros(q.shape), 0.0
        begin = min(bisect_left(samples, t - _SLOPE_TIME, key=_TIME), earlier - 1)
        times, positions, _ = zip(*samples[begin:])
        weights = np.array(times)
        mean = float(weights.sum()) / len(times)
        weights -= mean
        return weights @ np.array(positions) / (weights @ weights), t - mean

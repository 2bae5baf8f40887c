"""The filtered derivative: a second-order Butterworth low-pass that yields its own derivative."""

from math import log
from math import pi
from math import sqrt

import numpy as np

DAMPING = 1 / sqrt(2)  # of a second-order Butterworth filter


class ButterworthDerivative:
    r"""
    Low-pass u and differentiate it: x'' = w^2 (u - x) - 2 zeta w x'.

    Integrated by the trapezoidal rule with the true time step of every sample, which is stable
    for any step. x follows u, and x' follows du/dt, with the same delay.

    Parameters
    ----------
    cutoff : float
        Cut-off frequency w / (2 pi) [Hz].

    Attributes
    ----------
    value, derivative : ndarray
        x, in u's unit, and x', in u's unit per second.
    delay : float
        Group delay of x and of x' at low frequency [s]: 2 zeta / w.
    settling_time : float
        Time in which the envelope of what the filter began with decays to 1 % [s].

    """

    def __init__(self, cutoff: float):
        self._w = 2 * pi * cutoff
        self._u = None
        self.value = None
        self.derivative = None
        self.delay = 2 * DAMPING / self._w
        self.settling_time = log(100.0) / (DAMPING * self._w)

    def reset(self, u: np.ndarray):
        """Start at rest at u, any shape."""
        self._u = u
        self.value = u
        self.derivative = np.zeros(np.shape(u))

    def update(self, u: np.ndarray, dt: float):
        """
        Take the next sample, dt seconds after the last.

        With a dt of zero the state stays, and the next step starts from u.
        """
        a = dt * self._w * DAMPING
        b = (dt * self._w) ** 2 / 4
        x, x_dot = self.value, self.derivative
        self.derivative = ((1 - a - b) * x_dot
                           + (dt * self._w ** 2) * (0.5 * (self._u + u) - x)) / (1 + a + b)
        self.value = x + (0.5 * dt) * (x_dot + self.derivative)
        self._u = u

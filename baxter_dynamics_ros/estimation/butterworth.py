"""Filtered derivative: a second-order Butterworth low-pass that also returns its derivative."""

from math import log, pi, sqrt

import numpy as np

from ..model.arrays import Array

DAMPING = 1 / sqrt(2)  # of a second-order Butterworth filter


class ButterworthDerivative:
    r"""
    Low-pass filter and derivative of u: x'' = w^2 (u - x) - 2 zeta w x'.

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
        Time in which the envelope of the initial error decays to 1 % [s].

    """

    def __init__(self, cutoff: float) -> None:
        self._w = 2 * pi * cutoff
        self._dt: float | None = None
        self._step: Array = np.zeros((3, 3))  # transition of dt, multiplied from the right
        self.delay = 2 * DAMPING / self._w
        self.settling_time = log(100.0) / (DAMPING * self._w)
        self.reset(np.zeros(()))

    def reset(self, u: Array) -> None:
        """Start at rest at u, of any shape."""
        # (..., 3): x', u - x at the previous sample, u - x at the newest.
        self._state: Array = np.zeros(np.shape(u) + (3,))
        self.value = u
        self.derivative: Array = self._state[..., 0]

    def update(self, u: Array, dt: float) -> None:
        """
        Process the next sample, dt seconds after the previous one.

        If dt is zero, the state stays and the next step starts from u.
        """
        if dt != self._dt:
            self._dt, self._step = dt, self._trapezoid(dt)
        self._state[..., 2] = u - self.value
        self._state = self._state.dot(self._step)  # x', u - x, and the change of x
        self.derivative = self._state[..., 0]
        self.value = self.value + self._state[..., 2]

    def _trapezoid(self, dt: float) -> Array:
        """Return the transition matrix (3, 3) of a trapezoidal step of dt [s]."""
        a = dt * self._w * DAMPING
        b = (dt * self._w) ** 2 / 4
        c = dt * self._w ** 2 / 2
        return np.array([[1 - a - b, -dt, dt], [c, -b, b], [c, 1 + a, b]]) / (1 + a + b)

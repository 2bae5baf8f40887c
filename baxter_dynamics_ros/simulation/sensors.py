"""Sensor model of the real robot: noise, quantisation, and a lagging velocity."""

from collections import deque

import numpy as np

from ..model.arrays import Array
from ..model.joints import N_JOINTS

# Measured on real arms at rest; joint order s0 ... w2.
POSITION_QUANTUM = 2 * np.pi / 16384  # [rad]
EFFORT_QUANTUM = 0.004  # [N m]
EFFORT_NOISE = np.array([0.075, 0.037, 0.075, 0.035, 0.008, 0.016, 0.011])  # sd [N m]
# Chosen so that the published velocity has the measured noise of 0.013 rad/s.
ENCODER_NOISE = 4.8e-4  # sd [rad]

# The published velocity is the difference of two means over 6 encoder readings, 22 readings
# apart, which makes it lag by (2.5 + 24.5) / 2 = 13.5 ms.
MEAN_LENGTH = 6
DISTANCE = 22

_MAX_PENDING = 1000  # readings processed in one go; bounds memory


class Sensors:
    """
    Joint sensors of one arm, read every ``period`` [s]; 1 ms on the robot.

    Without noise there is no quantisation either; the velocity lags either way.
    """

    def __init__(self, period: float, noise: bool = True, seed: int = 0) -> None:
        self._period = period
        self._noise = noise
        self._random = np.random.default_rng(seed)
        self._encoder: deque[Array] = deque(maxlen=MEAN_LENGTH + DISTANCE)
        self._pending: list[Array] = []  # true positions not yet sampled by the encoder
        self._effort: Array = np.zeros(N_JOINTS)

    def read(self, q: Array, effort: Array) -> None:
        """Record the true position (7,) [rad] and effort (7,) [N m] at this instant."""
        self._pending.append(q)
        self._effort = effort
        if len(self._pending) >= _MAX_PENDING:
            self._sample()

    def publish(self) -> tuple[Array, Array, Array]:
        """Return position [rad], velocity [rad/s] and effort [N m] as the robot publishes them."""
        self._sample()
        readings = np.array(self._encoder)
        velocity = (readings[-MEAN_LENGTH:].mean(0) - readings[:MEAN_LENGTH].mean(0)) / (
            DISTANCE * self._period)
        effort = self._effort
        if self._noise:
            effort = _quantised(effort + EFFORT_NOISE * self._random.standard_normal(N_JOINTS),
                                EFFORT_QUANTUM)
        return readings[-1], velocity, effort

    def _sample(self) -> None:
        """Sample the pending positions in one vectorised step."""
        if not self._pending:
            return
        q = np.array(self._pending)
        self._pending.clear()
        if self._noise:
            q = _quantised(q + ENCODER_NOISE * self._random.standard_normal(q.shape),
                           POSITION_QUANTUM)
        if not self._encoder:  # the arm was at rest before the first reading
            self._encoder.extend([q[0]] * (MEAN_LENGTH + DISTANCE))
        self._encoder.extend(q)


def _quantised(x: Array, quantum: float) -> Array:
    return np.round(x / quantum) * quantum

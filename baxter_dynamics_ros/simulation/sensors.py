"""Sensor model of the real robot: noise, quantisation, and a lagging velocity."""

from collections import deque

import numpy as np

from ..model.arrays import Array
from ..model.joints import N_JOINTS

PERIOD = 0.001  # of the encoder's readings [s]
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


class Sensors:
    """Joint sensors of one arm; without noise there is no quantisation, but the same lag."""

    def __init__(self, noise: bool = True, seed: int = 0) -> None:
        self._noise = noise
        self._random = np.random.default_rng(seed)
        self._encoder: deque[Array] = deque(maxlen=MEAN_LENGTH + DISTANCE)
        self._pending: list[Array] = []  # true positions (7,) not yet sampled by the encoder [rad]

    def read(self, q: Array) -> None:
        """Read the true position (7,) [rad], once every PERIOD."""
        self._pending.append(q)

    def publish(self, effort: Array) -> tuple[Array, Array, Array]:
        """
        Return position [rad], velocity [rad/s] and effort [N m] as the robot publishes them.

        ``effort`` (7,) [N m] is the true one.
        """
        if self._pending:
            self._sample(np.array(self._pending))
            self._pending.clear()
        readings = np.array(self._encoder)
        velocity = (readings[-MEAN_LENGTH:].mean(0) - readings[:MEAN_LENGTH].mean(0)) / (
            DISTANCE * PERIOD)
        if self._noise:
            effort = _quantised(effort + EFFORT_NOISE * self._random.standard_normal(N_JOINTS),
                                EFFORT_QUANTUM)
        return readings[-1], velocity, effort

    def _sample(self, q: Array) -> None:
        """Sample positions (n, 7) [rad]."""
        if self._noise:
            q = _quantised(q + ENCODER_NOISE * self._random.standard_normal(q.shape),
                           POSITION_QUANTUM)
        if not self._encoder:  # the arm was at rest before the first reading
            self._encoder.extend([q[0]] * (MEAN_LENGTH + DISTANCE))
        self._encoder.extend(q)


def _quantised(x: Array, quantum: float) -> Array:
    return np.round(x / quantum) * quantum

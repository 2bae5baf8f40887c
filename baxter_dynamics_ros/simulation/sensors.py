"""What the real robot's sensors make of the truth: noise, quanta, and a velocity that lags."""

from collections import deque

import numpy as np

from ..model.arrays import Array
from ..model.joints import N_JOINTS

# Measured on real arms at rest; joint order s0 ... w2.
POSITION_QUANTUM = 2 * np.pi / 16384  # [rad]
EFFORT_QUANTUM = 0.004  # [N m]
EFFORT_NOISE = np.array([0.075, 0.037, 0.075, 0.035, 0.008, 0.016, 0.011])  # sd [N m]
# An encoder noise that gives the published velocity its 0.013 rad/s.
ENCODER_NOISE = 4.8e-4  # sd [rad]

# The published velocity is the difference of two means over 6 encoder readings, 22 readings
# apart, which makes it lag by (2.5 + 24.5) / 2 = 13.5 ms.
MEAN_LENGTH = 6
DISTANCE = 22

_TOGETHER = 1000  # readings that are looked at together at most: keeps memory flat


class Sensors:
    """
    The sensors of one arm, read at the encoder's rate.

    Parameters
    ----------
    period : float
        Time between two encoder readings [s]; 1 ms on the robot.
    noise : bool
        Whether there are noise and quanta; the velocity lags either way.
    seed : int
        Of the noise.

    """

    def __init__(self, period: float, noise: bool = True, seed: int = 0) -> None:
        self._period = period
        self._noise = noise
        self._random = np.random.default_rng(seed)
        self._encoder: deque[Array] = deque(maxlen=MEAN_LENGTH + DISTANCE)
        self._unread: list[Array] = []  # true positions since the encoder was last looked at
        self._effort: Array = np.zeros(N_JOINTS)

    def read(self, q: Array, effort: Array) -> None:
        """Take the true position (7,) [rad] and effort (7,) [N m] of this instant."""
        self._unread.append(q)
        self._effort = effort
        if len(self._unread) >= _TOGETHER:
            self._look()

    def publish(self) -> tuple[Array, Array, Array]:
        """Return position [rad], velocity [rad/s] and effort [N m] as the robot publishes them."""
        self._look()
        readings = np.array(self._encoder)
        velocity = (readings[-MEAN_LENGTH:].mean(0) - readings[:MEAN_LENGTH].mean(0)) / (
            DISTANCE * self._period)
        effort = self._effort
        if self._noise:
            effort = _quantised(effort + EFFORT_NOISE * self._random.standard_normal(N_JOINTS),
                                EFFORT_QUANTUM)
        return readings[-1], velocity, effort

    def _look(self) -> None:
        """Let the encoder read what it has not yet: many instants at once cost as much as one."""
        if not self._unread:
            return
        q = np.array(self._unread)
        self._unread.clear()
        if self._noise:
            q = _quantised(q + ENCODER_NOISE * self._random.standard_normal(q.shape),
                           POSITION_QUANTUM)
        if not self._encoder:  # the arm was at rest before
            self._encoder.extend([q[0]] * (MEAN_LENGTH + DISTANCE))
        self._encoder.extend(q)


def _quantised(x: Array, quantum: float) -> Array:
    return np.round(x / quantum) * quantum

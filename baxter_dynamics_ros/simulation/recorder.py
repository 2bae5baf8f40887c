"""Joint states of the fake Baxter, in the order of publication by the robot."""

from collections.abc import Iterator

import numpy as np

from .robot import FakeBaxter, GRIPPER_NAMES, GRIPPER_RATE, JOINT_STATE_NAMES
from ..model.arrays import Array

# Stamp [ns], names, position, velocity and effort.
Message = tuple[int, tuple[str, ...], Array, Array, Array]

STAMP_JITTER = 4e-5  # sd of the robot's own stamps [s]
START_NS = 10 ** 18  # stamp of a recording's start, a date in 2001 [ns]

_TOLERANCE = 500_000  # on a recording's end; the jitter of stamps is far smaller [ns]


class JointStates:
    """
    Joint states that a robot publishes from its present time.

    The head and both arms are published at ``rate`` [Hz], two gripper joints at 38 Hz. Each
    message advances the simulation to its instant.
    """

    def __init__(self, robot: FakeBaxter, rate: float, seed: int, start_ns: int):
        self.start_ns = start_ns  # stamp of the start [ns]; assign a later value to skip time
        self._robot = robot
        self._begin = robot.time
        self._period = 1.0 / rate
        self._random = np.random.default_rng(seed)
        self._arms = self._grippers = 0  # number of messages
        self._arms_due = self._draw()
        self._grippers_due = _ns(1.0 / GRIPPER_RATE)

    @property
    def due_ns(self) -> int:
        """Stamp of the next message [ns]."""
        return self.start_ns + min(self._arms_due, self._grippers_due)

    def take(self) -> Message:
        """Return stamp [ns], names, position, velocity and effort of the next message."""
        stamp = self.due_ns
        if self._grippers_due < self._arms_due:
            self._grippers += 1
            self._grippers_due = _ns((self._grippers + 1) / GRIPPER_RATE)
            still = np.zeros(len(GRIPPER_NAMES))
            return stamp, GRIPPER_NAMES, still, still, still
        self._arms += 1
        self._robot.advance(self._begin + self._arms * self._period)
        self._arms_due = self._draw()
        return stamp, JOINT_STATE_NAMES, *self._robot.joint_state()

    def _draw(self) -> int:
        """Return the stamp of the arms' next joint state, relative to the start [ns]."""
        return _ns((self._arms + 1) * self._period + self._random.normal(0.0, STAMP_JITTER))


def record(robot: FakeBaxter, duration: float, rate: float, seed: int = 0) -> Iterator[Message]:
    """
    Yield the joint states of the robot's next ``duration`` [s], faster than real time.

    The arms' rate is in Hz, the seed is that of the stamps' jitter, and the stamps begin at
    :data:`START_NS`.
    """
    states = JointStates(robot, rate, seed, START_NS)
    while states.due_ns < START_NS + _ns(duration) + _TOLERANCE:
        yield states.take()


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)

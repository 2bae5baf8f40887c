"""Static postures that identify a payload, and a joint motion that visits them in turn."""

import numpy as np

from .trajectories import minimum_jerk
from ..model.arrays import Array

# Of the right arm [rad]. A random search over collision-free postures chose the three that
# identify mass and centre of mass of a payload best; none is near a joint limit.
POSTURES = np.array([[0.30, -0.54, 0.01, 0.66, -1.62, 1.57, -0.27],
                     [0.66, -1.10, -0.12, 1.15, -0.36, 0.11, 0.27],
                     [0.92, -0.38, -0.72, 0.98, -0.23, 1.71, 0.81]])

MOVE = 1.5  # duration of a minimum-jerk move between postures [s]
REST = 2.0  # rest in each posture [s]
PERIOD = 2 * len(POSTURES) * (REST + MOVE)  # two laps [s]
# In the second lap each joint overshoots and returns during the rest, so that it reaches the
# posture from the other side: the overshoot is several times the angle that reverses friction.
OVERSHOOT = 0.08  # [rad]
RETURN_TIME = 0.6  # [s]


def motion(t: float) -> Array:
    """Return the right arm's joint angles (7,) [rad] at time t [s]; twice differentiable."""
    count, rest = divmod(t, REST + MOVE)
    n = int(count)
    before, here, then = (POSTURES[k % len(POSTURES)] for k in (n - 1, n, n + 1))
    start = here + _overshoot(n) * np.sign(here - before)
    end = then + _overshoot(n + 1) * np.sign(then - here)
    q: Array = (start + (here - start) * _progress(rest / RETURN_TIME)
                + (end - here) * _progress((rest - REST) / MOVE))
    return q


def _overshoot(n: int) -> float:
    """Return the overshoot of the n-th move [rad]."""
    return OVERSHOOT if n // len(POSTURES) % 2 else 0.0


def _progress(s: float) -> float:
    """Return the progress of a move, 0 to 1, at the fraction s of its duration, clipped."""
    return float(minimum_jerk(min(max(s, 0.0), 1.0)))

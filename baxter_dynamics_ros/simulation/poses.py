"""Resting in one place, and in three by turns: postures that show what the hand carries."""

import numpy as np

from .trajectories import Along, least_jerk, mirror
from ..model.arrays import Array

# The right arm's: of those that keep clear of the robot, the three that tell mass and centre of
# mass of a payload apart best, by a random search; none of it is near a joint's limit [rad].
POSTURES = np.array([[0.30, -0.54, 0.01, 0.66, -1.62, 1.57, -0.27],
                     [0.66, -1.10, -0.12, 1.15, -0.36, 0.11, 0.27],
                     [0.92, -0.38, -0.72, 0.98, -0.23, 1.71, 0.81]])

MOVE = 1.5  # [s] from one posture to the next, by the move of least jerk
REST = 2.0  # [s] in each
PERIOD = 2 * len(POSTURES) * (REST + MOVE)  # [s], two laps
# In the second lap every joint goes too far by so much, several times what turns its friction
# round, and comes back within so long of the rest: it comes from the other side.
BEYOND = 0.08  # [rad]
BACK = 0.6  # [s]


def motion(t: float) -> Array:
    """Return the right arm's joints at t [s], (7,) [rad]: twice continuously differentiable."""
    count, rest = divmod(t, REST + MOVE)
    n = int(count)
    before, here, then = (POSTURES[k % len(POSTURES)] for k in (n - 1, n, n + 1))
    start = here + _beyond(n) * np.sign(here - before)
    end = then + _beyond(n + 1) * np.sign(then - here)
    q: Array = (start + (here - start) * _moved(rest / BACK)
                + (end - here) * _moved((rest - REST) / MOVE))
    return q


def _beyond(n: int) -> float:
    """Return by how much the n-th way goes too far [rad]."""
    return BEYOND if n // len(POSTURES) % 2 else 0.0


def _moved(s: float) -> float:
    """Return how far a move has come, 0 to 1, after the part s of its time, which may be over."""
    return float(least_jerk(min(max(s, 0.0), 1.0)))


class Poses(Along):
    """
    Joint references through the postures, over and over.

    Parameters
    ----------
    side : str
        'right' or 'left'; the left arm's is the mirror image.

    """

    def __init__(self, side: str) -> None:
        signs = mirror(side)
        super().__init__(lambda t: signs * motion(t))


class Still(Along):
    """
    Joint references that stay.

    Parameters
    ----------
    q : ndarray (7,)
        Where [rad].

    """

    def __init__(self, q: Array) -> None:
        here = np.array(q)
        super().__init__(lambda t: here)

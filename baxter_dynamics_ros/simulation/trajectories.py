"""Trajectories of the fake Baxter: the paper's, and postures that identify a payload."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..model import Array, BaxterArm, mount
from ..model.joints import POSITION_LOWER, POSITION_UPPER

RAMP = 2.0  # duration of the acceleration from rest to full speed [s]
_CORRECTION = 5.0  # feedback gain that keeps the integrated reference on the curve [1/s]
_POSTURE = 0.5  # null-space gain towards the initial posture [1/s]

_SWITCH_PERIOD = 2.0  # time between two switches [s]
_SWITCH_TIME = 0.6  # duration of a switch [s]

# Signs that mirror joint angles between the arms.
MIRROR = np.array([-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0])

# Right arm, hand down, elbow up: initial guess of the first posture [rad].
_GUESS = np.array([0.3, -0.6, 0.0, 1.4, 0.0, 0.77, 0.0])

# Of the right arm [rad]. A random search over collision-free postures chose the three that
# identify mass and centre of mass of a payload best; none is near a joint limit.
POSTURES = np.array([[0.30, -0.54, 0.01, 0.66, -1.62, 1.57, -0.27],
                     [0.66, -1.10, -0.12, 1.15, -0.36, 0.11, 0.27],
                     [0.92, -0.38, -0.72, 0.98, -0.23, 1.71, 0.81]])
MOVE = 1.5  # duration of a minimum-jerk move between postures [s]
REST = 2.0  # rest in each posture [s]
# In every second lap each joint overshoots and returns during the rest, so that it reaches the
# posture from the other side: the overshoot is several times the angle that reverses friction.
OVERSHOOT = 0.08  # [rad]
RETURN_TIME = 0.6  # [s]


def mirror(side: str) -> Array:
    """Return the signs (7,) that turn the right arm's angles into the given arm's."""
    return MIRROR if side == 'left' else np.ones(len(MIRROR))


def minimum_jerk(s: Any) -> Any:
    """Return the progress, 0 to 1, of a minimum-jerk move at the fraction s of its duration."""
    return s ** 3 * (10.0 - 15.0 * s + 6.0 * s ** 2)


def circle(t: float) -> Array:
    """
    Return the hand's position (3,) [m] at t [s], trajectory 3(a) of the paper (caption of fig. 5).

    It is read in the robot's base frame. The left arm's is its mirror image.
    """
    return np.array([0.6 + 0.1 * np.sin(t), -0.2 + 0.1 * np.cos(t), 0.1 + 0.1 * np.cos(0.2 * t)])


def switch(t: float) -> Array:
    """
    Return the hand's position at t, trajectory 3(b) of the paper: switched quickly in y.

    The paper gives no numbers. Chosen here: y from -0.1 to -0.3 m or back every 2 s, by a
    minimum-jerk move in the last 0.6 s of them (0.63 m/s, 3.2 m/s^2 at most).
    """
    count, rest = divmod(t, _SWITCH_PERIOD)
    s = max(0.0, 1.0 - (_SWITCH_PERIOD - rest) / _SWITCH_TIME)  # of the move, 0 to 1
    moved = minimum_jerk(s)
    return np.array([0.6, -0.1 - 0.2 * (1.0 - moved if count % 2 else moved), 0.1])


def lift(t: float) -> Array:
    """Return the hand's position at t, trajectory 3(c): slowly up and down; numbers are ours."""
    return np.array([0.6, -0.2, 0.1 + 0.15 * np.sin(0.5 * t)])


TRAJECTORIES: dict[str, Callable[[float], Array]] = {
    'circle': circle, 'switch': switch, 'lift': lift, 'hold': lambda t: circle(0.0)}
# Time after which each trajectory repeats [s].
PERIODS = {'circle': 10 * np.pi, 'switch': 2 * _SWITCH_PERIOD, 'lift': 4 * np.pi}


def poses(t: float) -> Array:
    """Return the right arm's angles (7,) [rad] at t [s] through POSTURES, twice differentiable."""
    count, rest = divmod(t, REST + MOVE)
    here, start, end = POSTURES[int(count) % len(POSTURES)], _reached(count), _reached(count + 1)
    back, on = (float(minimum_jerk(min(max(s, 0.0), 1.0)))
                for s in (rest / RETURN_TIME, (rest - REST) / MOVE))
    return start + (here - start) * back + (end - here) * on


def _reached(count: float) -> Array:
    """Return the angles (7,) [rad] at the end of a move: a posture, or beyond it."""
    n = int(count)
    before, here = POSTURES[(n - 1) % len(POSTURES)], POSTURES[n % len(POSTURES)]
    overshoot = OVERSHOOT if n // len(POSTURES) % 2 else 0.0
    return np.asarray(here + overshoot * np.sign(here - before))


class JointTrajectory:
    """Joint references along a motion, which returns joint angles (7,) [rad] at a time [s]."""

    def __init__(self, motion: Callable[[float], Array]) -> None:
        self._motion = motion
        self._t = 0.0
        self.q = motion(0.0)  # the reference now (7,) [rad]
        self.qd: Array = np.zeros(len(self.q))  # [rad/s]

    def advance(self, dt: float) -> None:
        """Advance by dt [s]; qd becomes the mean velocity over the step."""
        self._t += dt
        q = self._motion(self._t)
        self.qd = (q - self.q) / dt
        self.q = q


class HandTrajectory:
    """
    Joint references along a hand trajectory, by the inverse Jacobian method of eq. (15).

    The hand points down throughout; the reference q [rad] and qd [rad/s], each (7,), starts at
    rest and accelerates along one of :data:`TRAJECTORIES`.
    """

    def __init__(self, side: str, trajectory: str) -> None:
        self._arm = BaxterArm(mount=mount(side))
        self._position = TRAJECTORIES[trajectory]
        self._mirror = np.array([1.0, -1.0 if side == 'left' else 1.0, 1.0])
        self._t = 0.0
        self.q = _GUESS * mirror(side)
        for _ in range(100):  # solve for the first posture from the guess
            self.q = self.q + 0.5 * self._inverse(np.zeros(3), 1.0)[0]
        self._posture = self.q
        self.qd: Array = np.zeros(len(self.q))

    def advance(self, dt: float) -> None:
        """Integrate eq. (15) over dt [s]."""
        now, then = _phase(self._t), _phase(self._t + dt)
        velocity = self._mirror * (self._position(then) - self._position(now)) / dt
        step, null_space = self._inverse(velocity, _CORRECTION)
        self.qd = step + null_space @ (_POSTURE * (self._posture - self.q))
        self.q = np.clip(self.q + dt * self.qd, POSITION_LOWER, POSITION_UPPER)
        self._t += dt

    def _inverse(self, velocity: Array, gain: float) -> tuple[Array, Array]:
        """Return joint velocities for a hand velocity with error feedback, and the null space."""
        pose = self._arm.forward_kinematics(self.q)
        jacobian = self._arm.jacobian(self.q)
        wanted = self._mirror * self._position(_phase(self._t))
        tilt = np.array([-pose[1, 2], pose[0, 2], 0.0])  # z x (0, 0, -1) turns the hand down
        error = np.concatenate([wanted - pose[:3, 3], tilt])
        inverse = np.linalg.pinv(jacobian)
        twist = np.concatenate([velocity, np.zeros(3)]) + gain * error
        return inverse @ twist, np.eye(len(self.q)) - inverse @ jacobian


def _phase(t: float) -> float:
    """Return the path parameter at time t: its rate rises smoothly from 0 to 1 within RAMP."""
    if t >= RAMP:
        return t - RAMP / 2
    return t / 2 - RAMP / (2 * np.pi) * float(np.sin(np.pi * t / RAMP))

"""Exciting joint trajectory: makes every parameter of a calibration identifiable; as files."""

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from .trajectories import minimum_jerk, mirror
from ..files import write_file
from ..model import Array, ArrayLike, joint_names, SIDES

DURATION = 60.0  # [s]
_EASE = 4.0  # duration of the fade-in and of the fade-out [s]
_STEP = 0.01  # [s]
_WINDOW = 50  # steps before and after a fast part in which the motion slows down

# Sufficient for a motion below 0.5 Hz. The SDK's player solves a system of equations with one
# unknown per line of the file.
_PLAN_RATE = 20.0  # at full speed [Hz]
# Sufficient with velocities and accelerations; the file still fits into a command line.
_TRAJECTORY_RATE = 4.0  # at full speed [Hz]
# Rest pose of the other arm: the SDK's neutral pose, the same for both arms [rad].
NEUTRAL = (0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0)
_OPEN = 100.0  # gripper position [%]


class Series(NamedTuple):
    """Fourier series of the seven joint angles around a centre."""

    center: Array  # (7,) [rad]
    harmonic: Array  # (7, k) multiples of the frequency 1 / DURATION
    sine: Array  # (7, k) amplitudes [rad]
    cosine: Array  # (7, k) amplitudes [rad]


# Right arm: rounded result of search(seed=2, evaluations=10_000) in tools/excitation_search.py.
SERIES = Series(
    center=np.array([-0.034, -0.445, 0.027, 1.320, 0.156, 0.299, -0.231]),
    harmonic=np.array([[2, 3, 9, 14, 20],
                       [4, 6, 10, 13, 20],
                       [2, 4, 7, 8, 19],
                       [1, 8, 11, 14, 23],
                       [2, 6, 10, 18, 24],
                       [4, 7, 11, 19, 29],
                       [5, 7, 13, 20, 24]]),
    sine=np.array([[0.429, 0.027, -0.361, 0.025, -0.113],
                   [0.260, 0.189, -0.018, -0.023, -0.112],
                   [-1.048, 0.331, 0.016, 0.043, -0.048],
                   [-0.158, 0.218, -0.153, -0.133, 0.096],
                   [1.434, -0.221, -0.282, -0.022, -0.072],
                   [-0.822, 0.157, -0.122, -0.038, -0.081],
                   [1.061, -0.093, -0.419, -0.267, -0.108]]),
    cosine=np.array([[0.437, -0.207, 0.079, 0.045, -0.210],
                     [1.175, 0.103, 0.148, -0.008, -0.050],
                     [-1.233, -0.157, 0.132, -0.541, 0.245],
                     [-0.660, 0.104, 0.186, 0.008, -0.019],
                     [-0.996, -0.594, -0.717, -0.159, -0.270],
                     [0.904, 0.266, -0.139, 0.077, 0.154],
                     [-0.121, 0.419, -0.107, -0.246, -0.082]]))


def motion(series: Series, t: ArrayLike) -> tuple[Array, Array, Array]:
    """
    Return position, velocity and acceleration at t (...) [s], each (..., 7), in radians.

    A window makes the motion start and end at rest, twice continuously differentiable. Outside
    the window the arm rests at the centre.
    """
    t = np.clip(t, 0.0, DURATION)[..., None]
    frequency = 2 * np.pi / DURATION * series.harmonic  # [rad/s]
    phase = frequency * t[..., None]
    sin, cos = np.sin(phase), np.cos(phase)
    s = series.sine * sin + series.cosine * cos
    sd = frequency * (series.sine * cos - series.cosine * sin)
    sdd = -frequency ** 2 * s
    s, sd, sdd = s.sum(-1), sd.sum(-1), sdd.sum(-1)
    u = np.minimum(np.minimum(t, DURATION - t) / _EASE, 1.0)
    slope = np.where(t < DURATION / 2, 1.0, -1.0) / _EASE  # of u, where it is not constant
    w = minimum_jerk(u)
    wd = 30.0 * (u * (1.0 - u)) ** 2 * slope
    wdd = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) * slope ** 2
    return (series.center + w * s, wd * s + w * sd, wdd * s + 2.0 * wd * sd + w * sdd)


def series(side: str) -> Series:
    """Return the series of an arm; the left arm mirrors the right one."""
    signs = mirror(side)
    return SERIES._replace(center=signs * SERIES.center, sine=signs[:, None] * SERIES.sine,
                           cosine=signs[:, None] * SERIES.cosine)


class LimitedMotion:
    """
    The exciting trajectory of an arm, slower where a joint would exceed a velocity [rad/s].

    The path stays as it is, and acceleration stays continuous.
    """

    def __init__(self, side: str, max_velocity: float = np.inf) -> None:
        self._series = series(side)
        self._phase = np.linspace(0.0, DURATION, round(DURATION / _STEP) + 1)  # time at full speed
        speed = np.abs(motion(self._series, self._phase)[1]).max(axis=1)
        needed = np.maximum(speed / (0.999 * max_velocity), 1.0)
        # The largest value within a window, smoothed over the same window, is never below.
        highest = sliding_window_view(np.pad(needed, 2 * _WINDOW, 'edge'), 2 * _WINDOW + 1).max(1)
        weights = np.hanning(2 * _WINDOW + 3)[1:-1]
        self._slowdown = np.convolve(highest, weights / weights.sum(), 'valid')
        steps = _STEP * (self._slowdown[1:] + self._slowdown[:-1]) / 2.0
        self._time = np.concatenate([[0.0], np.cumsum(steps)])
        self.duration = float(self._time[-1])  # [s]

    def __call__(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Return position, velocity and acceleration at t (...), each (..., 7); see motion."""
        phase = np.interp(np.asarray(t, dtype=float), self._time, self._phase)
        slope = np.interp(phase, self._phase, np.gradient(self._slowdown, _STEP))[..., None]
        rate = 1.0 / np.interp(phase, self._phase, self._slowdown)[..., None]
        q, qd, qdd = motion(self._series, phase)
        return q, rate * qd, rate ** 2 * qdd - slope * rate ** 3 * qd

    def waypoints(self, rate: float) -> Array:
        """Return times (n,) [s], as dense along the path as a rate [Hz] at full speed."""
        phase = np.linspace(0.0, DURATION, round(DURATION * rate) + 1)
        return np.interp(phase, self._phase, self._time)


def write_plan(path: str | Path, side: str, motion: LimitedMotion) -> None:
    """
    Write the exciting trajectory in the format of the SDK's ``joint_recorder.py``.

    The SDK's ``joint_trajectory_file_playback.py`` needs the columns of both arms and grippers and
    moves both arms: the other arm moves to :data:`NEUTRAL` and stays there; electric grippers
    open. The move to the first line is not collision-checked.
    """
    times = motion.waypoints(_PLAN_RATE)
    header, columns = ['time'], [times]
    for arm in reversed(SIDES):  # the SDK's order: left, right
        header += [*joint_names(arm), f'{arm}_gripper']
        q = motion(times)[0] if arm == side else np.tile(NEUTRAL, (len(times), 1))
        columns += [*q.T, np.full(len(times), _OPEN)]
    lines = [','.join(header)] + [','.join(f'{x:.6f}' for x in row) for row in zip(*columns)]
    write_file(path, '\n'.join(lines) + '\n')


def write_trajectory(path: str | Path, side: str, motion: LimitedMotion) -> None:
    """
    Write the exciting trajectory as a ``trajectory_msgs/JointTrajectory`` in JSON, which is YAML.

    It serves as the field ``trajectory`` of a goal of ``FollowJointTrajectory``. The move to the
    first point is not collision-checked.
    """
    times = motion.waypoints(_TRAJECTORY_RATE).round(6)
    points = [{'positions': q, 'velocities': qd, 'accelerations': qdd,
               'time_from_start': {'sec': int(t // 1), 'nanosec': round(t % 1 * 1e9)}}
              for t, q, qd, qdd in zip(times.tolist(), *(
                  values.round(5).tolist() for values in motion(times)))]
    lines = ',\n'.join(json.dumps(point, separators=(',', ':')) for point in points)
    names = json.dumps(joint_names(side))
    write_file(path, f'{{"joint_names": {names}, "points": [\n{lines}]}}\n')

"""Exciting trajectory as files: for the Baxter SDK's playback, and as a JointTrajectory."""

import json
from pathlib import Path

import numpy as np

from .exciting_trajectory import LimitedMotion
from ..files import write_file
from ..model.joints import joint_names, SIDES

# Sufficient for a motion below 0.5 Hz. The SDK's player solves a system of equations with one
# unknown per line of the file.
_PLAN_RATE = 20.0  # at full speed [Hz]
# Sufficient with velocities and accelerations; the file still fits into a command line.
_TRAJECTORY_RATE = 4.0  # at full speed [Hz]
# Rest pose of the other arm: the SDK's neutral pose, the same for both arms [rad].
NEUTRAL = (0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0)
_OPEN = 100.0  # gripper position [%]


def write_plan(path: str | Path, side: str, motion: LimitedMotion) -> None:
    """
    Write the exciting trajectory in the format of the SDK's ``joint_recorder.py``.

    The SDK's ``joint_trajectory_file_playback.py`` needs the columns of both arms and grippers and
    moves both arms: the other arm moves to :data:`NEUTRAL` and stays there; electric grippers
    open. The move to the first line is not collision-checked. An existing file is replaced.
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
    first point is not collision-checked. An existing file is replaced.
    """
    times = motion.waypoints(_TRAJECTORY_RATE).round(6)
    points = [{'positions': q, 'velocities': qd, 'accelerations': qdd,
               'time_from_start': {'sec': int(t // 1), 'nanosec': round(t % 1 * 1e9)}}
              for t, q, qd, qdd in zip(times.tolist(), *(
                  values.round(5).tolist() for values in motion(times)))]
    lines = ',\n'.join(json.dumps(point, separators=(',', ':')) for point in points)
    names = json.dumps(joint_names(side))
    write_file(path, f'{{"joint_names": {names}, "points": [\n{lines}]}}\n')

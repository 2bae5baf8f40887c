"""Exciting trajectory as a file for the playback examples of the Baxter SDK."""

from pathlib import Path

import numpy as np

from .exciting_trajectory import DURATION, motion, series
from ..files import write_file
from ..model.joints import joint_names, SIDES

# Sufficient for a motion below 0.5 Hz. The SDK's player solves a system of equations with one
# unknown per line of the file.
RATE = 20.0  # lines per second [Hz]
# Rest pose of the other arm: the SDK's neutral pose, the same for both arms [rad].
NEUTRAL = (0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0)
_OPEN = 100.0  # gripper position [%]


def write_plan(path: str | Path, side: str, rate: float = RATE) -> None:
    """
    Write the exciting trajectory in the format of the SDK's ``joint_recorder.py``.

    The SDK's ``joint_trajectory_file_playback.py`` needs the columns of both arms and grippers and
    moves both arms: the other arm moves to :data:`NEUTRAL` and stays there; electric grippers
    open. The move to the first line is not collision-checked.

    Parameters
    ----------
    path : Path
        Output file; an existing file is replaced.
    side : str
        Arm that moves, 'right' or 'left'.
    rate : float
        Lines per second [Hz].

    Raises
    ------
    BaxterDynamicsError
        If the file cannot be written.

    """
    times = np.arange(round(DURATION * rate) + 1) / rate
    header, columns = ['time'], [times]
    for arm in reversed(SIDES):  # the SDK's order: left, right
        header += [*joint_names(arm), f'{arm}_gripper']
        q = motion(series(side), times)[0] if arm == side else np.tile(NEUTRAL, (len(times), 1))
        columns += [*q.T, np.full(len(times), _OPEN)]
    lines = [','.join(header)] + [','.join(f'{x:.6f}' for x in row) for row in zip(*columns)]
    write_file(path, '\n'.join(lines) + '\n')

"""The exciting trajectory as a file that the Baxter SDK's examples play."""

from pathlib import Path

import numpy as np

from .exciting_trajectory import DURATION, motion, series
from ..files import write_file
from ..model.joints import joint_names, SIDES

# Lines a second. Enough for a motion without anything above 0.5 Hz; the SDK's player solves an
# equation with as many unknowns as the file has lines.
RATE = 20.0  # [Hz]
# Where the other arm waits: the SDK's neutral pose, which is the same for both arms [rad].
NEUTRAL = (0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0)
_OPEN = 100.0  # a gripper's position [%]


def write_plan(path: str | Path, side: str, rate: float = RATE) -> None:
    """
    Write the exciting trajectory as the SDK's ``joint_recorder.py`` would. Nothing moves.

    The SDK's ``joint_trajectory_file_playback.py`` wants all columns, both grippers' among them,
    and moves both arms: the other arm goes to :data:`NEUTRAL` and stays there; electric grippers
    open. On its way from where the arms are to the first line it takes no care of anything.

    Parameters
    ----------
    path : Path
        The file; one that exists is replaced.
    side : str
        The arm that moves, 'right' or 'left'.
    rate : float
        Lines a second [Hz].

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

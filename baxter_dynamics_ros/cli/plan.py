"""calibrate --plan: the exciting trajectory, run on the fake Baxter and written to a file."""

import argparse

import numpy as np

from .experiment import BAG, record_bag
from .paths import new_folder
from .terminal import say, show_table
from ..model.joints import joint_names
from ..simulation.exciting_trajectory import DURATION, motion, series
from ..simulation.plan_file import write_plan
from ..simulation.robot import FakeBaxter

PLAN = 'plan.csv'  # in the output folder
_RATE = 100.0  # of the recording [Hz]
_REST = 1.0  # [s] recorded after the end, until the arm is at rest


def plan(args: argparse.Namespace) -> int:
    """Print the exciting trajectory, record it on the fake Baxter, and write it as a file."""
    folder = new_folder(args.output or 'baxter_plan')
    arm = args.arm or 'right'
    _describe(arm)
    record_bag(folder / BAG, FakeBaxter(arm, 'exciting', seed=args.seed), DURATION + _REST, _RATE,
               args.seed)
    write_plan(folder / PLAN, arm)
    say(f"for the SDK's joint_trajectory_file_playback.py: {folder / PLAN}",
        'Keep 1.2 m around the arm clear, and move both arms to the first waypoint by hand: '
        'the move to the first waypoint is not collision-checked.')
    return 0


def _describe(arm: str) -> None:
    t = np.arange(0.0, DURATION, 0.01)
    q, qd, qdd = motion(series(arm), t)
    turns = (np.diff(np.sign(qd[1:]), axis=0) != 0).sum(axis=0)
    say(f'exciting trajectory, {DURATION:g} s, from rest to rest')
    columns = {'from, rad': q.min(axis=0), 'to, rad': q.max(axis=0),
               'speed, rad/s': np.abs(qd).max(axis=0),
               'acceleration, rad/s²': np.abs(qdd).max(axis=0)}
    show_table(('joint', *columns, 'reversals'), [
        (joint, *(f'{column[i]:.2f}' for column in columns.values()), str(turns[i]))
        for i, joint in enumerate(joint_names(arm))])

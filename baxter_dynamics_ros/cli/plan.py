"""What to move a robot by for a calibration: the exciting trajectory, described and tried."""

import argparse

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from .experiment import BAG, new_folder, record_bag
from ..model.joints import joint_names
from ..simulation.exciting_trajectory import DURATION, motion, series
from ..simulation.plan_file import write_plan
from ..simulation.robot import FakeBaxter

PLAN = 'plan.csv'  # in the output folder
_RATE = 100.0  # of the recording [Hz]
_REST = 1.0  # [s] recorded after the end, until the arm has come to rest


def main(args: argparse.Namespace) -> int:
    """Print the exciting trajectory, record it on the fake Baxter, and write it as a file."""
    console = Console()
    folder = new_folder(args.output or 'baxter_plan')
    arm = args.arm or 'right'
    _describe(console, arm)
    record_bag(folder / BAG, FakeBaxter(arm, 'exciting', seed=args.seed), DURATION + _REST, _RATE,
               args.seed, console)
    write_plan(folder / PLAN, arm)
    console.print(f"for the SDK's joint_trajectory_file_playback.py: {folder / PLAN}\n"
                  'Keep 1.2 m around the arm free, and bring both arms to the first line '
                  "before: the player's way there takes no care of anything.",
                  soft_wrap=True, highlight=False)
    return 0


def _describe(console: Console, arm: str) -> None:
    t = np.arange(0.0, DURATION, 0.01)
    q, qd, qdd = motion(series(arm), t)
    turns = (np.diff(np.sign(qd[1:]), axis=0) != 0).sum(axis=0)
    console.print(f'the exciting trajectory, {DURATION:g} s, from rest to rest',
                  soft_wrap=True, highlight=False)
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column('joint', no_wrap=True)
    columns = {'from, rad': q.min(axis=0), 'to, rad': q.max(axis=0),
               'speed, rad/s': np.abs(qd).max(axis=0),
               'acceleration, rad/s²': np.abs(qdd).max(axis=0)}
    for title in (*columns, 'turns round'):
        table.add_column(title, justify='right')
    for i, joint in enumerate(joint_names(arm)):
        table.add_row(joint, *(f'{column[i]:.2f}' for column in columns.values()),
                      str(turns[i]))
    console.print(table)

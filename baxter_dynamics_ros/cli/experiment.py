"""
Record one of the paper's trajectories on the fake Baxter and evaluate it.

The trajectories are 3(a) circle, 3(b) switch and 3(c) lift; the recording is a rosbag2. No real
robot is commanded.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from .options import add, number, output_path
from .terminal import progress, say
from ..simulation.trajectories import PERIODS

if TYPE_CHECKING:
    from ..simulation.robot import FakeBaxter

TOPIC = '/robot/joint_states'
BAG, REPORT = 'bag', 'report'  # in the output folder

START_UP = 3.0  # [s] not recorded, until the controller settles
_SETTLING = 0.3  # [s] recorded before the periods, until the predictor settles
# About a minute in whole periods, so that means are not biased [s].
DURATIONS = {name: _SETTLING + repeats * PERIODS[name]
             for name, repeats in {'circle': 2, 'switch': 16, 'lift': 5}.items()}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics experiment``."""
    parser.add_argument('trajectory', choices=tuple(PERIODS))
    parser.add_argument('-o', '--output', metavar='DIR',
                        help='new folder for the bag and the report '
                        '(default: baxter_experiment_TRAJECTORY)')
    parser.add_argument('--rate', type=float, choices=(50.0, 100.0), default=100.0, metavar='HZ',
                        help='joint states per second: 50, as in the paper, or 100 (default)')
    parser.add_argument('--duration', type=number(2, 3600, 'seconds'), metavar='SECONDS',
                        help='duration of the recording (default: whole periods, about a minute)')
    add(parser, '--arm')
    add(parser, '--seed')


def main(args: argparse.Namespace) -> int:
    """Record a trajectory of the paper on the fake Baxter and evaluate the recording."""
    from .main import parse
    from ..simulation.robot import FakeBaxter
    folder = output_path('--output', args.output or f'baxter_experiment_{args.trajectory}',
                         force=None)
    robot = FakeBaxter(args.arm, args.trajectory, seed=args.seed)
    robot.advance(START_UP)
    duration = args.duration or DURATIONS[args.trajectory]
    record_bag(folder / BAG, robot, duration, args.rate, args.seed)
    evaluation = parse(['evaluate', str(folder / BAG), '--output', str(folder / REPORT),
                        '--arm', args.arm])
    evaluation.command_line = args.command_line
    return int(evaluation.main(evaluation))


def record_bag(path: Path, robot: FakeBaxter, duration: float, rate: float, seed: int) -> None:
    """Record the robot's next duration [s] at a rate [Hz] to a rosbag2 folder; print one line."""
    from ..recordings.bags import new_bag
    from ..simulation.robot import JOINT_STATE_NAMES, record
    path.parent.mkdir(parents=True, exist_ok=True)
    count, start = 0, robot.time
    with new_bag(path) as bag, progress(duration) as update:
        for stamp, names, position, velocity, effort in record(robot, duration, rate, seed):
            bag.joint_state(TOPIC, stamp, names, position, velocity, effort)
            count += names is JOINT_STATE_NAMES
            update(robot.time - start, 'recording the fake Baxter')
    say(f'recorded {count} joint states of {duration:.1f} s on {TOPIC}: {path}')

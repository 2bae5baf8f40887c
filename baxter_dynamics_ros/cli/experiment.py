"""experiment: one of the paper's trajectories on the fake Baxter, recorded and evaluated."""

import argparse
from pathlib import Path

from . import evaluate
from .console import progress
from .options import add_arm, add_seed, number
from .printing import say
from ..model.exceptions import BaxterDynamicsError
from ..recordings.parameter_file import NODE
from ..recordings.writer import BagWriter
from ..simulation.recorder import record
from ..simulation.robot import FakeBaxter, JOINT_STATE_NAMES
from ..simulation.trajectories import PERIODS

TOPIC = '/robot/joint_states'
BAG, REPORT = 'bag', 'report'  # in the output folder

START_UP = 3.0  # [s] not recorded, until the controller settles
_SETTLING = 0.3  # [s] recorded before the periods, until the predictor settles
# Whole periods, so that means are not biased; all take about a minute.
_REPEATS = {'circle': 2, 'switch': 16, 'lift': 5}


DESCRIPTION = (
    "Run one of the paper's trajectories, 3(a) circle, 3(b) switch or 3(c) lift, on the fake "
    'Baxter, record it as a rosbag2, and evaluate the recording. No real robot is commanded.')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics experiment``."""
    parser.add_argument('trajectory', choices=tuple(PERIODS))
    parser.add_argument('-o', '--output', metavar='DIR',
                        help='new folder for the bag and the report '
                        '(default: baxter_experiment_TRAJECTORY)')
    parser.add_argument('--rate', type=float, choices=(50.0, 100.0), default=100.0,
                        help='joint states per second; the paper has 50 (default: 100)')
    parser.add_argument('--duration', type=number(2, 3600, 'seconds'), metavar='SECONDS',
                        help='length of the recording (default: whole periods of the trajectory, '
                        'about a minute)')
    add_arm(parser)
    add_seed(parser)


def main(args: argparse.Namespace) -> int:
    """Record a trajectory of the paper on the fake Baxter and evaluate the recording."""
    folder = new_folder(args.output or f'baxter_experiment_{args.trajectory}')
    robot = FakeBaxter(args.arm, args.trajectory, seed=args.seed)
    robot.advance(START_UP)
    duration = args.duration or whole_periods(args.trajectory)
    record_bag(folder / BAG, robot, duration, args.rate, args.seed)
    return evaluate.main(argparse.Namespace(
        bags=[folder / BAG], output=folder / REPORT, arm=args.arm, topic=None, params=[],
        node=NODE, save_bag=None, force=False, command_line=args.command_line))


def whole_periods(trajectory: str) -> float:
    """Return the duration of a recording of whole periods of a trajectory [s]."""
    return _SETTLING + _REPEATS[trajectory] * PERIODS[trajectory]


def record_bag(path: Path, robot: FakeBaxter, duration: float, rate: float,
               seed: int) -> None:
    """
    Record the joint states of a fake Baxter to a new rosbag2 folder, and print one line.

    Parameters
    ----------
    path : Path
        The folder; it appears when it is complete.
    robot : FakeBaxter
        The robot.
    duration : float
        Simulated time [s].
    rate : float
        Joint states per second [Hz].
    seed : int
        Seed of the jitter of the stamps.

    """
    count, start = 0, robot.time
    with BagWriter(path) as bag, progress(duration) as update:
        for stamp, names, position, velocity, effort in record(robot, duration, rate, seed):
            bag.joint_state(TOPIC, stamp, names, position, velocity, effort)
            count += names is JOINT_STATE_NAMES
            update(robot.time - start, 'recording the fake Baxter')
    say(f'recorded {count} joint states of {duration:.1f} s on {TOPIC}: {path}')


def new_folder(output: str) -> Path:
    """Create an output folder and return it; raise BaxterDynamicsError unless it is empty."""
    path = Path(output).expanduser().resolve()
    try:
        path.mkdir(exist_ok=True)
        filled = any(path.iterdir())
    except OSError as error:
        raise BaxterDynamicsError(
            f'--output: {path} cannot be created ({error.strerror})') from None
    if filled:
        raise BaxterDynamicsError(f'--output: {path} is not empty; name a new folder')
    return path

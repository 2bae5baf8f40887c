"""The paper's experiment on the fake Baxter: one of its three trajectories, and its evaluation."""

from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from . import evaluate
from ..model.exceptions import BaxterDynamicsError
from ..recordings.writer import BagWriter
from ..simulation.recorder import record
from ..simulation.robot import FakeBaxter, JOINT_STATE_NAMES
from ..simulation.trajectories import PERIODS

TOPIC = '/robot/joint_states'
BAG, REPORT = 'bag', 'report'  # in the output folder

START_UP = 3.0  # [s] not recorded: the trajectory comes up to speed, the controller settles
_SETTLING = 0.3  # [s] recorded before the periods: a predictor gives nothing until it settles
# Whole periods of the trajectory, so that a mean is one over all of it; all take about a minute.
_REPEATS = {'circle': 2, 'switch': 16, 'lift': 5}


def run(trajectory: str, output: str, rate: float, duration: 'float | None', arm: str,
        seed: int, command: str) -> int:
    """
    Record a trajectory of the paper on the fake Baxter, and evaluate the recording.

    The folder gets ``bag`` and ``report``.

    Parameters
    ----------
    trajectory : str
        'circle', 'switch' or 'lift': the paper's 3(a), 3(b), 3(c).
    output : str
        Folder, new or empty.
    rate : float
        Joint states a second [Hz].
    duration : float or None
        How long to record [s]; None for :func:`whole_periods`.
    arm : str
        'right' or 'left'.
    seed : int
        Of the sensors' noise and the stamps' jitter.
    command : str
        The command line, for the report.

    Returns
    -------
    int
        Exit code 0.

    Raises
    ------
    BaxterDynamicsError
        If the folder is not empty or cannot be written.

    """
    console = Console()
    folder = new_folder(output)
    robot = FakeBaxter(arm, trajectory, seed=seed)
    robot.advance(START_UP)
    duration = whole_periods(trajectory) if duration is None else duration
    record_bag(folder / BAG, robot, duration, rate, seed, console)
    return evaluate.run([folder / BAG], folder / REPORT, arm, None, None, None, command)


def whole_periods(trajectory: str) -> float:
    """Return how long to record for a mean over whole periods of a trajectory [s]."""
    return _SETTLING + _REPEATS[trajectory] * PERIODS[trajectory]


def record_bag(path: Path, robot: FakeBaxter, duration: float, rate: float, seed: int,
               console: Console) -> None:
    """
    Record what a fake Baxter publishes from now on, and print one line about it.

    Parameters
    ----------
    path : Path
        The new rosbag2 folder; it is there when it is complete.
    robot : FakeBaxter
        The robot.
    duration : float
        Of the robot's time [s].
    rate : float
        Joint states a second [Hz].
    seed : int
        Of the stamps' jitter.
    console : Console
        Where to print.

    Raises
    ------
    BaxterDynamicsError
        If the bag cannot be written.

    """
    count, start = 0, robot.time
    with BagWriter(path) as bag, Progress(console=console, transient=True,
                                          disable=not console.is_terminal) as progress:
        task = progress.add_task('recording the fake Baxter', total=duration)
        for stamp, names, position, velocity, effort in record(robot, duration, rate, seed):
            bag.joint_state(TOPIC, stamp, names, position, velocity, effort)
            count += names is JOINT_STATE_NAMES
            progress.update(task, completed=robot.time - start)
    console.print(f'recorded {count} joint states of {duration:.1f} s on {TOPIC}: {path}',
                  soft_wrap=True, highlight=False)


def new_folder(output: str) -> Path:
    """
    Return the output folder, which exists and is empty.

    Raises
    ------
    BaxterDynamicsError
        If there is something in it, or it cannot be made.

    """
    path = Path(output).expanduser().resolve()
    try:
        path.mkdir(exist_ok=True)
        filled = any(path.iterdir())
    except OSError as error:
        raise BaxterDynamicsError(
            f'--output: {path} cannot be a folder ({error.strerror})') from None
    if filled:
        raise BaxterDynamicsError(f'--output: {path} is not empty; name a new folder')
    return path

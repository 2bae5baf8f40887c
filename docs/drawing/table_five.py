"""The paper's Table V beside that of the fake Baxter on the paper's three trajectories."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Iterator

from baxter_dynamics_ros import JOINTS
from baxter_dynamics_ros.calibration.calibrate_robot import calibrate
from baxter_dynamics_ros.cli.experiment import DURATIONS, START_UP, TOPIC
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.paper_tables import TABLE_V, TABLE_V_SUM
from baxter_dynamics_ros.recordings.evaluate_recordings import Evaluator
from baxter_dynamics_ros.recordings.evaluation_results import Evaluation
from baxter_dynamics_ros.simulation.exciting_trajectory import DURATION
from baxter_dynamics_ros.simulation.robot import FakeBaxter, record
import numpy as np

SETS = ('circle', 'switch', 'lift')  # the paper's sets 1 to 3, trajectories 3(a) to 3(c)
SIDE, RATE = 'right', 100.0  # [Hz]
_REST = 1.0  # recorded by `calibrate --plan` after the exciting motion [s]

_PAPER = {'paper, L-E': 'lagrange_euler', 'paper, RN-E': 'newton_euler'}


class Recording:
    """Recording of `experiment` or `calibrate --plan`, in memory."""

    topic, arm = TOPIC, SIDE

    def __init__(self, trajectory: str) -> None:
        self.name = trajectory
        robot = FakeBaxter(SIDE, trajectory)
        duration = DURATION + _REST
        if trajectory in SETS:
            robot.advance(START_UP)
            duration = DURATIONS[trajectory]
        self._states = list(record(robot, duration, RATE))

    def __iter__(self) -> Iterator[tuple[Any, ...]]:
        """Iterate over the joint states, as those of a bag."""
        return ((stamp, *fields, stamp) for stamp, *fields in self._states)


recording = lru_cache(maxsize=None)(Recording)


@lru_cache(maxsize=None)
def calibrated() -> PredictorSettings:
    """Return the settings of a calibration on the exciting motion."""
    return calibrate([recording('exciting')]).after


@lru_cache(maxsize=None)
def evaluation(trajectory: str, is_calibrated: bool) -> Evaluation:
    """Evaluate the recording of a trajectory, with the defaults or calibrated."""
    settings = calibrated() if is_calibrated else PredictorSettings()
    return Evaluator(settings).evaluate(recording(trajectory))


def rows(trajectory: str) -> dict[str, np.ndarray]:
    """Return the signed means of e and the RMS (7,) [N m] by name."""
    number = SETS.index(trajectory)
    found = {name: np.array(TABLE_V[method][number]) for name, method in _PAPER.items()}
    for name, is_calibrated in (('defaults', False), ('calibrated', True)):
        errors = evaluation(trajectory, is_calibrated).methods['lagrange_euler']
        found[f'ours, {name}'], found[f'RMS, {name}'] = errors.signed_mean, errors.rms
    return found


def table() -> str:
    """Return the table as text."""
    lines = ['|signed mean| of e and, below, RMS of e [N m]; sum: of the signed means']
    for number, trajectory in enumerate(SETS):
        head = f'set {number + 1}, {trajectory}'
        lines.append(f'{head:16}' + ''.join(f'{joint:>8}' for joint in (*JOINTS, 'sum')))
        for name, values in rows(trajectory).items():
            line = f'{name:16}' + ''.join(f'{abs(x):8.4f}' for x in values)
            if name in _PAPER:
                line += f'{TABLE_V_SUM[_PAPER[name]][number]:8.4f}'
            elif name.startswith('ours'):
                line += f'{values.sum():8.4f}'
            lines.append(line)
    return '\n'.join(lines)

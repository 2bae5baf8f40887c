"""Figure of what a residual looks like, and why: eight runs of the fake Baxter."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import JOINTS
from baxter_dynamics_ros.model.parameters import Payload
from baxter_dynamics_ros.simulation.plant import COULOMB
from baxter_dynamics_ros.simulation.recorder import record
from baxter_dynamics_ros.simulation.robot import FakeBaxter
import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

START, DURATION = 6.0, 8.0  # [s]: after the start-up, what is shown
FRICTION = {'effort_model.coulomb': COULOMB}  # what calibration would find
RESIDUAL, OTHER = '#b3401f', '#9aa5b1'


class Case(NamedTuple):
    """One run: what is shown of it, what the robot has, and what the predictor is told."""

    title: str
    joint: str
    trajectory: str
    robot: dict[str, Any] = {}
    told: dict[str, Any] = {}
    force: tuple[float, float, float] = (0.0, 0.0, 0.0)  # on the hand, from 2 s to 4 s [N]
    beside: str = ''  # drawn thinly: velocity or acceleration


CASES = (
    Case('all is known: noise', 's1', 'lift', told=FRICTION),
    Case('friction is not told: follows the sign of q̇', 's1', 'lift', beside='velocity'),
    Case('1 kg in the hand is not told', 's1', 'lift', {'payload': Payload(1.0, (0, 0, 0.03))},
         told=FRICTION),
    Case('20 N push the hand down, from 2 s to 4 s', 's1', 'lift', told=FRICTION,
         force=(0.0, 0.0, -20.0)),
    Case('the base is tilted by 2°, not told', 's0', 'lift',
         {'gravity': (0.0, 9.81 * np.sin(np.radians(2)), -9.81 * np.cos(np.radians(2)))},
         told=FRICTION),
    Case('effort_model.enabled is false, beside a robot', 's1', 'lift',
         told={'effort_model.enabled': False}),
    Case('velocity_lag is 0, beside a robot: swings with each q̈', 's0', 'switch',
         told={**FRICTION, 'acceleration.velocity_lag': 0.0}, beside='acceleration'),
    Case('align is false: the same, larger', 's0', 'switch',
         told={**FRICTION, 'align': False}, beside='acceleration'),
)


def draw(path: Path) -> None:
    """Draw what residuals look like into a file."""
    with matplotlib.rc_context({'svg.hashsalt': 'residual', 'font.size': 9.0}):
        figure = Figure(figsize=(9.6, 9.6), facecolor='white', layout='constrained')
        grid = figure.subplots(4, 2)
        for axes, case in zip(grid.flat, CASES):
            _panel(axes, case)
        for axes in grid[-1]:
            axes.set_xlabel('time [s]')
        figure.savefig(path, dpi=100)


def _panel(axes: Axes, case: Case) -> None:
    joint = JOINTS.index(case.joint)
    time, residual, motion = _run(case)
    limit = max(1.0, 1.15 * float(np.abs(residual[:, joint]).max()))
    if case.beside:
        drawn = motion[case.beside][:, joint]
        axes.plot(time, 0.8 * limit * drawn / np.abs(drawn).max(), color=OTHER, lw=1.0,
                  label={'velocity': 'q̇', 'acceleration': 'q̈'}[case.beside] + ', any scale')
        axes.legend(loc='upper right', fontsize=8, frameon=False)
    axes.plot(time, residual[:, joint], color=RESIDUAL, lw=1.1)
    axes.axhline(0.0, color='black', lw=0.6)
    axes.set(title=case.title, ylabel=f'{case.joint}  [N m]', ylim=(-limit, limit),
             xlim=(0.0, DURATION))
    axes.title.set_size(9.5)
    axes.grid(alpha=0.25)


def _run(case: Case) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Return time (n,) [s], residual (n, 7) [N m], and velocity and acceleration (n, 7)."""
    robot = FakeBaxter('right', case.trajectory, **case.robot)
    predictor = Predictor(PredictorSettings.from_parameters(case.told))
    rows = []
    begin = None
    for message in record(robot, START + DURATION, 100.0):
        begin = message[0] if begin is None else begin
        shown = (message[0] - begin) * 1e-9 - START
        robot.force = case.force if 2.0 <= shown < 4.0 else (0.0, 0.0, 0.0)
        prediction = predictor.handle(*message).prediction
        if prediction is not None and shown >= 0.0:
            rows.append((shown, prediction.residual, prediction.qd, prediction.qdd))
    time, residual, velocity, acceleration = (np.array(column) for column in zip(*rows))
    return time, residual, {'velocity': velocity, 'acceleration': acceleration}

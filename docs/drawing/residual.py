"""Figures of residuals of the fake Baxter: causes, and the expected range."""

from __future__ import annotations

from typing import Any, NamedTuple

from baxter_dynamics_ros.estimation.explanation import UNCALIBRATED
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import JOINTS
from baxter_dynamics_ros.model.parameters import Payload
from baxter_dynamics_ros.report.drawing import draw_expected, FAINT, zero_line
from baxter_dynamics_ros.simulation.plant import COULOMB
from baxter_dynamics_ros.simulation.robot import FakeBaxter, record
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

from .sheet import drawn, legend, MODEL, panels, WRONG
from .table_five import calibrated

START, DURATION = 6.0, 8.0  # start-up, which is not shown, and duration [s]
_ROOM = 2.6  # half height of the panels with the expected range [N m]
FRICTION = {'effort_model.coulomb': COULOMB}  # known after a calibration


class Case(NamedTuple):
    """One run: the robot, the settings of the predictor, and what is shown."""

    title: str
    joint: str
    trajectory: str
    robot: dict[str, Any] = {}
    settings: dict[str, Any] = FRICTION
    force: tuple[float, float, float] = (0.0, 0.0, 0.0)  # on the hand, from 2 s to 4 s [N]
    beside: str = ''  # also drawn: qd or qdd


CASES = (
    Case('everything is modelled: noise', 's1', 'lift'),
    Case('friction is not modelled: sign of q̇', 's1', 'lift', settings={}, beside='qd'),
    Case('1 kg in the hand is not modelled', 's1', 'lift',
         {'payload': Payload(1.0, (0, 0, 0.03))}),
    Case('20 N push the hand down, from 2 s to 4 s', 's1', 'lift', force=(0.0, 0.0, -20.0)),
    Case('tilt of the base by 2° is not modelled', 's0', 'lift',
         {'gravity': (0.0, 9.81 * np.sin(np.radians(2)), -9.81 * np.cos(np.radians(2)))}),
    Case('effort_model.enabled is false beside a robot', 's1', 'lift',
         settings={'effort_model.enabled': False}),
    Case('velocity_lag is 0 beside a robot: follows q̈', 's0', 'switch',
         settings={**FRICTION, 'acceleration.velocity_lag': 0.0}, beside='qdd'),
    Case('align is false: the same, larger', 's0', 'switch',
         settings={**FRICTION, 'align': False}, beside='qdd'),
)


@drawn
def band() -> Figure:
    """Draw a residual during a push, with the range expected before and after a calibration."""
    joint = JOINTS.index('e1')
    figure, ((before,), (after,)) = panels(2, 1, 4.4, sharex=True, sharey=True)
    uncalibrated = PredictorSettings().replace({'effort_model.deviation': tuple(UNCALIBRATED)})
    for axis, settings, title in (
            (before, uncalibrated, 'not calibrated: the push may be an error of the model'),
            (after, calibrated(), 'calibrated: the push is beyond the expected range')):
        case = Case(title, 'e1', 'lift', settings=settings.parameters(), force=(0.0, 0.0, -8.0))
        time, residual, qd, qdd = (values[::2] for values in _run(case))
        deviation = settings.model.effort_model.deviation_at(qd, qdd)
        axis.plot(time, residual[:, joint], color=MODEL, lw=1.2, label='residual of e1')
        draw_expected(axis, time, deviation[:, joint])
        zero_line(axis)
        axis.axvspan(2.0, 4.0, ymax=0.04, color=WRONG, label='push of 8 N')
        axis.set(ylabel='e1 [N m]', xlim=(0.0, DURATION))
        axis.set_title(title, loc='left')
    after.set_xlabel('time [s]')
    before.set_ylim(-_ROOM, _ROOM)
    legend(figure)
    return figure


@drawn
def causes() -> Figure:
    """Draw the residual of each case."""
    figure, grid = panels(4, 2, 8.4, sharex=True)
    for axis, case in zip(grid.flat, CASES):
        _draw(axis, case)
    for axis in grid[-1]:
        axis.set_xlabel('time [s]')
    return figure


def _draw(axis: Axes, case: Case) -> None:
    joint = JOINTS.index(case.joint)
    time, residual, *motion = (column for column in _run(case))
    limit = max(1.0, 1.15 * float(np.abs(residual[:, joint]).max()))
    if case.beside:
        drawn = motion[case.beside == 'qdd'][:, joint]
        axis.plot(time, 0.8 * limit * drawn / np.abs(drawn).max(), color=FAINT, lw=1.0,
                  label={'qd': 'q̇', 'qdd': 'q̈'}[case.beside] + ', any scale')
        axis.legend(loc='upper right', fontsize=8, frameon=False)
    axis.plot(time, residual[:, joint], color=WRONG, lw=1.1)
    zero_line(axis)
    axis.set(ylabel=f'{case.joint} [N m]', ylim=(-limit, limit), xlim=(0.0, DURATION))
    axis.set_title(case.title, loc='left')


def _run(case: Case) -> tuple[np.ndarray, ...]:
    """Return time (n,) [s], residual [N m], velocity and acceleration (n, 7)."""
    robot = FakeBaxter('right', case.trajectory, **case.robot)
    predictor = Predictor(PredictorSettings.from_parameters(case.settings))
    rows = []
    begin = None
    for message in record(robot, START + DURATION, 100.0):
        begin = message[0] if begin is None else begin
        shown = (message[0] - begin) * 1e-9 - START
        robot.plant.force = np.array(case.force) * (2.0 <= shown < 4.0)
        prediction = predictor.handle(*message).prediction
        if prediction is not None and shown >= 0.0:
            rows.append((shown, prediction.residual, prediction.qd, prediction.qdd))
    return tuple(map(np.array, zip(*rows)))

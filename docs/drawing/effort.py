"""Figures of docs/effort.md: measured effort beyond torque."""

from __future__ import annotations

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.model.effort import EffortModel, Presliding
from baxter_dynamics_ros.model.joints import JOINTS, N_JOINTS, POSITION_LOWER, POSITION_UPPER, S1
from baxter_dynamics_ros.report.drawing import FAINT, SHADE, zero_line
from matplotlib.figure import Figure
import numpy as np

from .sheet import drawn, legend, MODEL, OTHER, panels, TRUE, WRONG

_ELBOWS = {'arm stretched out (e1 0)': 0.0, 'elbow bent (e1 1.57)': np.pi / 2}  # e1 [rad]
_COULOMB, _VISCOUS = np.full(N_JOINTS, 0.5), np.full(N_JOINTS, 0.2)  # [N m], [N m s/rad]


@drawn
def spring() -> Figure:
    """Draw the springs' effort over s1, with gravity's torque and their sum, the effort."""
    figure, ((left, right),) = panels(1, 2, 3.7, sharey=True)
    s1 = np.linspace(POSITION_LOWER[S1], POSITION_UPPER[S1], 300)
    model = EffortModel()
    for axis, (title, elbow) in zip((left, right), _ELBOWS.items()):
        q = _states(s1)
        q[:, JOINTS.index('e1')] = elbow
        gravity, springs = BaxterArm().gravity(q)[:, S1], model.spring(q)[:, S1]
        axis.axvspan(*model.spring_range, color=SHADE, zorder=0)
        axis.plot(s1, gravity, color=TRUE, linewidth=4.0, label='τ at rest: gravity')
        axis.plot(s1, springs, color=OTHER, linewidth=2.2, label='springs')
        axis.plot(s1, gravity + springs, color=MODEL, linewidth=1.8,
                  label='effort = τ + springs')
        zero_line(axis)
        axis.set(title=title, xlabel='s1 [rad]; up is negative')
    left.set_ylabel('at s1 [N m]')
    right.annotate('range of the spring model', (-1.85, -52.0), color=FAINT)
    legend(figure)
    return figure


@drawn
def friction() -> Figure:
    """Draw Coulomb and viscous friction over velocity, and Dahl's loop over position."""
    figure, ((left, right),) = panels(1, 2, 3.7)
    qd = np.linspace(-0.6, 0.6, 401)
    for label, model, color, width in (
            ('Coulomb', EffortModel(coulomb=_COULOMB), TRUE, 4.0),
            ('viscous', EffortModel(viscous=_VISCOUS), OTHER, 2.0),
            ('both', EffortModel(coulomb=_COULOMB, viscous=_VISCOUS), MODEL, 1.8)):
        left.plot(qd, model.friction(_states(qd))[:, S1], color=color, linewidth=width,
                  label=label)
    left.axvspan(-model.coulomb_velocity, model.coulomb_velocity, color=SHADE, zorder=0)
    left.annotate(f'±{model.coulomb_velocity:g} rad/s', (model.coulomb_velocity, -0.62), (6, 0),
                  textcoords='offset points', color=FAINT)
    left.set(xlabel='velocity [rad/s]', ylabel='friction [N m]',
             title='over velocity: 0.5 N m, 0.2 N m s/rad')
    t = np.linspace(0.0, 1.0, 4001)
    swing, small = 0.2 * np.sin(2 * np.pi * t), 0.02 * np.sin(4 * np.pi * t)
    dahl = Presliding(model.dahl_length)
    for label, path, color, width in (('Dahl, from rest', swing, MODEL, 1.8),
                                      ('Dahl, small motion', small, WRONG, 1.6)):
        right.plot(path, [0.5 * dahl.update(q)[S1] for q in _states(path)], color=color,
                   linewidth=width, label=label)
    right.plot(swing, 0.5 * np.sign(np.gradient(swing)), color=TRUE, linewidth=4.0, zorder=1,
               label='Coulomb, ideal')
    right.set(xlabel='position [rad]', ylim=(-0.68, 1.25),
              title=f'over position: 0.5 N m, reversing over {dahl.length:g} rad')
    for axis in (left, right):
        axis.legend(frameon=False, loc='upper left')
    return figure


def _states(s1: np.ndarray) -> np.ndarray:
    """Return values of all joints (n, 7), zero but for s1 (n,)."""
    values = np.zeros((len(s1), N_JOINTS))
    values[:, S1] = s1
    return values

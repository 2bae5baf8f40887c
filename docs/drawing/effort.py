"""The pictures of docs/effort.md: what measured effort has beyond torque."""

from __future__ import annotations

from pathlib import Path

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.joints import JOINTS, N_JOINTS, POSITION_LOWER, POSITION_UPPER, S1
from baxter_dynamics_ros.model.presliding import Presliding
import numpy as np

from .sheet import FAINT, legend, MODEL, OTHER, panels, styled, TRUE, write, WRONG

# Elbow straight and bent: e1 [rad].
_ELBOWS = {'arm stretched out (e1 0)': 0.0, 'elbow bent (e1 1.57)': np.pi / 2}
_COULOMB, _VISCOUS = np.full(N_JOINTS, 0.5), np.full(N_JOINTS, 0.2)  # [N m], [N m s/rad]


@styled
def spring(path: Path) -> None:
    """Draw the springs' effort over s1, with gravity's torque and their sum, the effort."""
    figure, ((left, right),) = panels(1, 2, 3.7, sharey=True)
    s1 = np.linspace(POSITION_LOWER[S1], POSITION_UPPER[S1], 300)
    model = EffortModel()
    for axis, (title, elbow) in zip((left, right), _ELBOWS.items()):
        q = np.zeros((len(s1), N_JOINTS))
        q[:, S1], q[:, JOINTS.index('e1')] = s1, elbow
        gravity, springs = BaxterArm().gravity(q)[:, S1], model.spring(q)[:, S1]
        axis.axvspan(*model.spring_range, color='#eef3f7', zorder=0)
        axis.plot(s1, gravity, color=TRUE, linewidth=4.0, label='τ at rest: gravity')
        axis.plot(s1, springs, color=OTHER, linewidth=2.2, label='springs')
        axis.plot(s1, gravity + springs, color=MODEL, linewidth=1.8,
                  label='effort = τ + springs')
        axis.axhline(0.0, color=FAINT, linewidth=0.8)
        axis.set_title(title)
        axis.set_xlabel('s1 [rad]; up is negative')
    left.set_ylabel('at s1 [N m]')
    right.annotate('range for which\nthe springs are known', (-1.85, -54.0), color=FAINT)
    legend(figure, left)
    write(figure, path)


@styled
def friction(path: Path) -> None:
    """Draw Coulomb and viscous friction over velocity, and Dahl's loop over position."""
    figure, ((left, right),) = panels(1, 2, 3.7)
    qd = np.zeros((401, N_JOINTS))
    qd[:, S1] = np.linspace(-0.6, 0.6, 401)
    coulomb = EffortModel(coulomb=_COULOMB)
    for label, model, color, width in (
            ('Coulomb', coulomb, TRUE, 4.0),
            ('viscous', EffortModel(viscous=_VISCOUS), OTHER, 2.0),
            ('both', EffortModel(coulomb=_COULOMB, viscous=_VISCOUS), MODEL, 1.8)):
        left.plot(qd[:, S1], model.friction(qd)[:, S1], color=color, linewidth=width, label=label)
    width = coulomb.coulomb_velocity
    left.axvspan(-width, width, color='#eef3f7', zorder=0)
    left.annotate(f'±{width:g} rad/s', (width, -0.62), (6, 0), textcoords='offset points',
                  color=FAINT)
    left.set_xlabel('velocity [rad/s]')
    left.set_ylabel('friction [N m]')
    left.set_title('over velocity: 0.5 N m, 0.2 N m s/rad')
    left.legend(frameon=False, loc='upper left')
    t = np.linspace(0.0, 1.0, 4001)
    path_of_s1 = np.concatenate([0.2 * np.sin(2 * np.pi * t), 0.02 * np.sin(4 * np.pi * t)])
    q = np.zeros((len(path_of_s1), N_JOINTS))
    q[:, S1] = path_of_s1
    dahl = Presliding(EffortModel().dahl_length)
    z = np.array([dahl.update(row)[S1] for row in q])
    direction = np.sign(np.gradient(path_of_s1[:len(t)]))
    right.plot(path_of_s1[:len(t)], 0.5 * direction, color=TRUE, linewidth=4.0,
               label='Coulomb, very sharp')
    right.plot(path_of_s1[:len(t)], 0.5 * z[:len(t)], color=MODEL, linewidth=1.8,
               label='Dahl, from rest')
    right.plot(path_of_s1[len(t):], 0.5 * z[len(t):], color=WRONG, linewidth=1.6,
               label='Dahl, small motion after it')
    right.set_xlabel('position [rad]')
    right.set_title(f'over position: 0.5 N m, turning over {dahl.length:g} rad')
    right.set_ylim(-0.68, 1.25)
    right.legend(frameon=False, loc='upper left')
    write(figure, path)

"""Figures of docs/model.md: the errors of the printed model."""

from __future__ import annotations

from typing import Any

from baxter_dynamics_ros import BaxterArm, JOINTS, mount
from baxter_dynamics_ros.model.lagrange_euler import transform
from baxter_dynamics_ros.model.parameters import CORRECTIONS, paper_parameters, THETA_2_OFFSET
from baxter_dynamics_ros.simulation.description import arm_description
from baxter_dynamics_ros.simulation.trajectories import HandTrajectory, PERIODS
from matplotlib.figure import Figure
import numpy as np
import pinocchio as pin

from .sheet import drawn, legend, MODEL, panels, TRUE, WRONG

SIDE = 'right'
_DT = 0.01  # [s]
_STYLES: tuple[dict[str, Any], ...] = (
    {'color': TRUE, 'linewidth': 6.0}, {'color': WRONG, 'linewidth': 1.8},
    {'color': MODEL, 'linewidth': 1.8})
# Joints from s0 to the hand that are not on the axis of the one before: index in the
# manufacturer's description, and the paper's frame.
_STICK = {'s0': (0, 0), 's1': (1, 2), 'e1': (3, 4), 'w1': (5, 6), 'hand': (7, 7)}
# Two postures in the plane of the arm [rad].
_POSTURES = {
    'all joint angles zero': (0.0,) * 7,
    's1 −0.6, e1 1.4, w1 0.77 rad: hand down': (0.0, -0.6, 0.0, 1.4, 0.0, 0.77, 0.0),
}


@drawn
def arm_as_printed() -> Figure:
    """Draw the arm by Table II as printed, corrected, and by the manufacturer."""
    figure, ((left, right),) = panels(1, 2, 3.9)
    labels = "manufacturer's description", 'Table II as printed', 'with θ₂ = q₂ + π/2'
    for axis, (title, posture) in zip((left, right), _POSTURES.items()):
        q = np.array(posture)
        lines = (_manufacturers_places(q), _places(q), _places(q, THETA_2_OFFSET))
        for label, style, line in zip(labels, _STYLES, lines):
            axis.plot(line[:, 0], line[:, 2], 'o-', label=label, **style,
                      markersize=3.0 + 1.6 * style['linewidth'])
        for name, (x, _, z) in zip(_STICK, lines[-1]):
            offset = (9, -13) if name in ('s0', 's1') else (9, 7)  # beside the lines [pt]
            axis.annotate(name, (x, z), offset, textcoords='offset points', color=MODEL)
        axis.annotate('hand', lines[1][-1, [0, 2]], (9, -3), textcoords='offset points',
                      color=WRONG)
        axis.set(title=title, aspect='equal', xlim=(-0.35, 1.3), ylim=(-0.25, 1.35),
                 xlabel='outwards from s0 [m]')
    left.set_ylabel('above s0 [m]')
    legend(figure)
    return figure


@drawn
def torque_as_printed() -> Figure:
    """Draw the torques of the circle by the model as printed, corrected, and the manufacturer."""
    motion, time = _circle()
    model, data = _manufacturer()
    lines = {"manufacturer's description": np.array([
        pin.rnea(model, data, *state).copy() for state in zip(*motion)])}
    for label, corrections in (('as printed', frozenset()), ('both corrections', CORRECTIONS)):
        arm = BaxterArm(mount=mount(SIDE), parameters=paper_parameters(corrections))
        lines[label] = arm.inverse_dynamics(*motion)
    figure, axes = panels(2, 2, 4.6, sharex=True)
    for axis, joint in zip(axes.flat, ('s1', 'e0', 'e1', 'w1')):
        for (label, tau), style in zip(lines.items(), _STYLES):
            axis.plot(time, tau[:, JOINTS.index(joint)], label=label, **style)
        axis.set_title(joint, loc='left', fontweight='bold')
        axis.set_ylabel('τ [N m]')
    for axis in axes[-1]:
        axis.set_xlabel('time [s]')
    legend(figure)
    return figure


def _circle() -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Return q, qd, qdd (n, 7) along one period of the circle, and the time (n,) [s]."""
    reference = HandTrajectory(SIDE, 'circle')
    start, steps = round(2.0 / _DT), round(PERIODS['circle'] / _DT)  # once it is up to speed
    q, qd = [], []
    for _ in range(start + steps + 2):
        reference.advance(_DT)
        q.append(reference.q)
        qd.append(reference.qd)
    qdd = np.gradient(np.array(qd), _DT, axis=0)
    rows = slice(start, start + steps)
    return (np.array(q)[rows], np.array(qd)[rows], qdd[rows]), _DT * np.arange(steps)


def _places(q: np.ndarray, *corrections: str) -> np.ndarray:
    """Return the positions of the stick by eq. (2), in frame {0}, (5, 3) [m]."""
    parameters = paper_parameters(frozenset(corrections))
    return np.array([transform(parameters, 0, frame, q)[:3, 3] for _, frame in _STICK.values()])


def _manufacturer() -> tuple[pin.Model, pin.Data]:
    model = pin.buildModelFromXML(arm_description(SIDE))
    return model, model.createData()


def _manufacturers_places(q: np.ndarray) -> np.ndarray:
    """Return the positions of the stick by the manufacturer's description, as above."""
    model, data = _manufacturer()
    pin.framesForwardKinematics(model, data, q)
    joints = [*(joint.translation for joint in list(data.oMi)[1:]),
              data.oMf[model.getFrameId(f'{SIDE}_hand_link')].translation]
    to_shoulder = np.linalg.inv(mount(SIDE))
    places = np.array([joints[joint] for joint, _ in _STICK.values()])
    return places @ to_shoulder[:3, :3].T + to_shoulder[:3, 3]

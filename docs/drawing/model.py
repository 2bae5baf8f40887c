"""The pictures of docs/model.md: what the printed model gets wrong."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from baxter_dynamics_ros import JOINTS, mount
from baxter_dynamics_ros.model.lagrange_euler import transform
from baxter_dynamics_ros.model.parameters import ArmParameters
from baxter_dynamics_ros.simulation.trajectories import HandTrajectory, PERIODS
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

from .manufacturer import Manufacturer, SIDE, variant
from .sheet import legend, MODEL, panels, styled, TRUE, write, WRONG

_DT = 0.01  # [s]
_STYLES: dict[str, dict[str, Any]] = {
    "manufacturer's description": {'color': TRUE, 'linewidth': 6.0},
    'Table II as printed': {'color': WRONG, 'linewidth': 1.8},
    'with θ₂ = q₂ + π/2': {'color': MODEL, 'linewidth': 1.8},
}
# The joints on the way from s0 to the hand that are not on the axis of the one before: their index
# among the manufacturer's, and the paper's frame there.
_STICK = {'s0': (0, 0), 's1': (1, 2), 'e1': (3, 4), 'w1': (5, 6), 'hand': (7, 7)}
# Two postures in the plane of the arm [rad].
_POSTURES = {
    'all joint angles zero': (0.0,) * 7,
    's1 −0.6, e1 1.4, w1 0.77 rad: hand down': (0.0, -0.6, 0.0, 1.4, 0.0, 0.77, 0.0),
}


@styled
def arm_as_printed(path: Path) -> None:
    """Draw where the arm is by Table II as printed, corrected, and by the manufacturer."""
    figure, ((left, right),) = panels(1, 2, 3.9)
    manufacturer = Manufacturer()
    to_shoulder = np.linalg.inv(mount(SIDE))
    for axis, (title, posture) in zip((left, right), _POSTURES.items()):
        q = np.array(posture)
        places = manufacturer.places(q) @ to_shoulder[:3, :3].T + to_shoulder[:3, 3]
        lines = (places[[joint for joint, _ in _STICK.values()]],
                 *(_origins(variant(name).parameters, q)
                   for name in ('as printed', 'pi/2 at theta_2')))
        for (label, style), line in zip(_STYLES.items(), lines):
            axis.plot(line[:, 0], line[:, 2], 'o-', label=label, **style,
                      markersize=3.0 + 1.6 * style['linewidth'])
        for name, (x, _, z) in zip(_STICK, lines[-1]):
            offset = (9, -13) if name in ('s0', 's1') else (9, 7)  # beside the lines [pt]
            axis.annotate(name, (x, z), offset, textcoords='offset points', color=MODEL)
        axis.annotate('hand', lines[1][-1, [0, 2]], (9, -3), textcoords='offset points',
                      color=WRONG)
        axis.set_title(title)
        axis.set_aspect('equal')
        axis.set_xlim(-0.35, 1.3)
        axis.set_ylim(-0.25, 1.35)
        axis.set_xlabel('outwards from s0 [m]')
    left.set_ylabel('above s0 [m]')
    legend(figure, left)
    write(figure, path)


@styled
def torque_as_printed(path: Path) -> None:
    """Draw the torques of the circle by the model as printed, corrected, and the manufacturer."""
    shown = ('s1', 'e0', 'e1', 'w1')
    motion, time = _motion('circle')
    lines = {"manufacturer's description": Manufacturer().inverse_dynamics(*motion),
             'as printed': variant('as printed').inverse_dynamics(*motion),
             'both corrections': variant('both').inverse_dynamics(*motion)}
    figure, axes = panels(2, 2, 4.6, sharex=True)
    for axis, joint in zip(axes.flat, shown):
        for (label, tau), style in zip(lines.items(), _STYLES.values()):
            axis.plot(time, tau[:, JOINTS.index(joint)], label=label, **style)
        _name(axis, joint, 'τ [N m]')
    _finish(figure, axes, path)


def _name(axis: Axes, joint: str, quantity: str) -> None:
    axis.set_title(joint, loc='left', fontweight='bold')
    axis.set_ylabel(quantity)


def _finish(figure: Figure, axes: np.ndarray, path: Path) -> None:
    for axis in axes[-1]:
        axis.set_xlabel('time [s]')
    legend(figure, axes[0, 0])
    write(figure, path)


def _motion(trajectory: str) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Return q, qd, qdd (n, 7) along one period of a reference, and the time (n,) [s]."""
    reference = HandTrajectory(SIDE, trajectory)
    start, steps = round(2.0 / _DT), round(PERIODS[trajectory] / _DT)  # once it is up to speed
    q, qd = [], []
    for _ in range(start + steps + 2):
        reference.advance(_DT)
        q.append(reference.q)
        qd.append(reference.qd)
    qdd = np.gradient(np.array(qd), _DT, axis=0)
    rows = slice(start, start + steps)
    return (np.array(q)[rows], np.array(qd)[rows], qdd[rows]), _DT * np.arange(steps)


def _origins(parameters: ArmParameters, q: np.ndarray) -> np.ndarray:
    """Return where the joints of the stick are by eq. (2), in frame {0}, (5, 3) [m]."""
    return np.array([transform(parameters, 0, frame, q)[:3, 3] for _, frame in _STICK.values()])

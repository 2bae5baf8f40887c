"""The picture of docs/model.md: the joints of an arm, their axes and positive directions."""

from __future__ import annotations

from baxter_dynamics_ros import BaxterArm, JOINTS, mount
from baxter_dynamics_ros.model.lagrange_euler import transform
from baxter_dynamics_ros.report.drawing import FAINT, INK
from matplotlib.axes import Axes
from matplotlib.figure import Figure
import numpy as np

from .sheet import drawn, MODEL, OTHER, panels, TRUE

_POSTURE = np.array([0.5, -0.25, 0.0, 0.9, 0.0, 0.7, 0.0])  # [rad]
_VIEW = np.radians((-70.0, 20.0))  # azimuth and elevation of the viewer
# How far along its axis a joint is drawn [m]: pairs of joints have a common centre.
_ALONG = {'s0': 0.0, 's1': 0.0, 'e0': 0.13, 'e1': 0.0, 'w0': 0.09, 'w1': 0.0, 'w2': 0.06}
_BESIDE = {'s0': (-18, -6), 'e0': (4, 18), 'w0': (-22, 0), 'w2': (-20, 4)}  # labels [pt]
_AXIS, _RADIUS = 0.17, 0.06  # drawn length of an axis, and radius of its rotation [m]


@drawn
def draw() -> Figure:
    """Draw the right arm with its joints."""
    figure, ((axis,),) = panels(1, 1, 5.6)
    arm = BaxterArm(mount=mount('right'))
    frames = [arm.mount @ transform(arm.parameters, 0, k, _POSTURE) for k in range(8)]
    origins = np.array([frame[:3, 3] for frame in frames])
    bends = [origins[k] + arm.parameters.d[k] * frames[k][:3, 2] for k in (0, 2, 4)]
    stick = np.array([origins[0], bends[0], origins[1], bends[1], origins[3], bends[2],
                      origins[5], origins[7]])
    _line(axis, np.vstack([np.zeros(3), origins[0]]), color=FAINT, linewidth=2.0)
    _line(axis, stick, color=TRUE, linewidth=13.0, solid_capstyle='round',
          solid_joinstyle='round', zorder=1)
    for k, joint in enumerate(JOINTS):
        x, y, z = frames[k][:3, :3].T
        center = origins[k] + _ALONG[joint] * z
        _arrow(axis, center, center + _AXIS * z, MODEL)
        turn = np.linspace(-0.6, 4.2, 60)[:, None]
        _turn(axis, center + 0.075 * z + _RADIUS * (np.cos(turn) * x + np.sin(turn) * y))
        axis.plot(*_seen(center), 'o', color=MODEL, markersize=6.0, zorder=4)
        axis.annotate(joint, _seen(center + _AXIS * z), _BESIDE.get(joint, (14, 4)),
                      textcoords='offset points', ha='center', va='center', color=MODEL,
                      fontweight='bold', fontsize=13.0, zorder=5, annotation_clip=False)
    axis.annotate('hand', _seen(origins[7]), (12, -4), textcoords='offset points', color=INK)
    for direction, name in zip(0.17 * np.eye(3), ('x, forward', 'y, left', 'z, up')):
        _arrow(axis, np.zeros(3), direction, INK)
        axis.annotate(name, _seen(direction), (5, 5), textcoords='offset points', color=INK)
    axis.annotate('base', _seen(np.zeros(3)), (-14, -14), textcoords='offset points', color=INK)
    axis.set_aspect('equal')
    axis.margins(0.1)
    axis.set_axis_off()
    return figure


def _seen(points: np.ndarray) -> np.ndarray:
    """Project points (..., 3) in the base frame onto the picture, (..., 2) [m]."""
    azimuth, elevation = _VIEW
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    away = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation),
                     np.sin(elevation)])
    return np.stack([points @ right, points @ np.cross(away, right)], axis=-1)


def _line(axis: Axes, points: np.ndarray, **style: object) -> None:
    axis.plot(*_seen(points).T, **style)


def _arrow(axis: Axes, start: np.ndarray, end: np.ndarray, color: str) -> None:
    axis.annotate('', _seen(end), _seen(start), annotation_clip=False, zorder=3, arrowprops={
        'arrowstyle': '-|>', 'color': color, 'linewidth': 1.8, 'shrinkA': 0.0, 'shrinkB': 0.0})


def _turn(axis: Axes, arc: np.ndarray) -> None:
    """Draw an arc that ends in an arrow."""
    _line(axis, arc[:-3], color=OTHER, linewidth=1.8, zorder=3)
    _arrow(axis, arc[-5], arc[-1], OTHER)

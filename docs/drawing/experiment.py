"""The pictures of docs/experiment.md: trajectories, the paper's figures 5 to 7, and Table V."""

from __future__ import annotations

from pathlib import Path

from baxter_dynamics_ros import BaxterArm, JOINTS, mount
from baxter_dynamics_ros.report.drawing import draw_band, frame, zero_line
from baxter_dynamics_ros.report.figures import STROKES
from baxter_dynamics_ros.simulation.trajectories import PERIODS, RAMP, HandTrajectory
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from measured.experiment import evaluation, rows, SETS, SIDE
import numpy as np

from .sheet import FAINT, legend, MODEL, OTHER, panels, styled, TRUE, WIDTH, write, WRONG

_DT = 0.02  # [s]
_INTERVALS = 1000  # that a line is drawn with
_SHOWN = 3  # periods at most
_LEAST = 1e-5  # [N m]: what is less is drawn there
_COLORS = ('#1b4f72', '#2f9880', '#e07b1a', '#a33b12', '#7d5ba6', '#56b4e9', '#8a94a0')
_DOT, _DASH = {'markersize': 5.5}, {'marker': '_', 'markersize': 13.0, 'markeredgewidth': 2.5}
_MARKS = {
    'paper, L-E': {'marker': 's', 'color': OTHER, **_DOT},
    'paper, RN-E': {'marker': 'D', 'color': TRUE, **_DOT},
    'ours, defaults': {'marker': 'o', 'color': MODEL, **_DOT},
    'ours, calibrated': {'marker': 'o', 'color': '#56b4e9', **_DOT},
    'RMS, defaults': {'color': WRONG, **_DASH},
    'RMS, calibrated': {'color': '#d89a83', **_DASH},
}
_TITLES = {'circle': '3(a) circle', 'switch': '3(b) switch', 'lift': '3(c) lift'}


@styled
def trajectories(path: Path) -> None:
    """Draw the hand's way along each trajectory, and below it how the joints move."""
    figure = Figure(figsize=(WIDTH, 6.0), layout='constrained')
    arm = BaxterArm(mount=mount(SIDE))
    for column, trajectory in enumerate(SETS):
        q = _reference(trajectory)
        hand = arm.forward_kinematics(q)[:, :3, 3]
        above = figure.add_subplot(2, 3, column + 1, projection='3d')
        above.plot(*hand.T, color=MODEL, linewidth=1.6)
        above.set_title(_TITLES[trajectory], pad=0.0)
        for name, low, high in zip('xyz', (0.45, -0.35, -0.1), (0.75, -0.05, 0.3)):
            getattr(above, f'set_{name}lim')(low, high)
            getattr(above, f'set_{name}label')(f'{name} [m]', labelpad=3.0 * (name != 'x'))
            getattr(above, f'{name}axis').set_major_locator(MultipleLocator(0.1))
        above.set_box_aspect((3, 3, 4), zoom=0.72)
        above.tick_params(labelsize=8, pad=0)
        below = figure.add_subplot(2, 3, column + 4)
        time = _DT * np.arange(len(q))
        for joint, angle, color in zip(JOINTS, (q - q[0]).T, _COLORS):
            below.plot(time, angle, color=color, linewidth=1.4, label=joint)
        below.margins(x=0.0)
        below.set_xlabel('time [s]')
        if not column:
            below.set_ylabel('joint angle − first [rad]')
            handles = below.get_legend_handles_labels()
    figure.legend(*handles, loc='outside lower center', ncols=7, frameon=False,
                  handlelength=1.4)
    write(figure, path)


@styled
def circle(path: Path) -> None:
    """Draw the paper's fig. 5 for the fake Baxter."""
    _efforts(path, 'circle')


@styled
def switch(path: Path) -> None:
    """Draw the paper's fig. 6 for the fake Baxter."""
    _efforts(path, 'switch')


@styled
def lift(path: Path) -> None:
    """Draw the paper's fig. 7 for the fake Baxter."""
    _efforts(path, 'lift')


@styled
def table_five(path: Path) -> None:
    """Draw Table V, the paper's and ours, and the RMS of the same errors."""
    figure, (axes,) = panels(1, 3, 4.2, sharey=True)
    for number, (axis, trajectory) in enumerate(zip(axes, SETS)):
        for name, values in rows(trajectory).items():
            axis.plot(JOINTS, np.maximum(np.abs(values), _LEAST), linestyle='', label=name,
                      **_MARKS[name])
        axis.set_yscale('log')
        axis.margins(x=0.06)
        axis.set_title(f'set {number + 1}, {_TITLES[trajectory]}')
    axes[0].set_ylabel('|signed mean| and RMS of e [N m]')
    handles = axes[0].get_legend_handles_labels()
    figure.legend(*handles, loc='outside upper center', ncols=3, frameon=False,
                  handletextpad=0.1)
    write(figure, path)


def _reference(trajectory: str) -> np.ndarray:
    """Return the joint references of one period, (n, 7) [rad]."""
    reference = HandTrajectory(SIDE, trajectory)
    q = []
    for _ in range(round((RAMP + PERIODS[trajectory]) / _DT)):
        reference.advance(_DT)
        q.append(reference.q)
    return np.array(q)[round(RAMP / _DT):]


def _efforts(path: Path, trajectory: str) -> None:
    """Draw measured and predicted effort, and both methods' errors, a row a joint."""
    found = evaluation(trajectory, False)
    figure, axes = panels(len(JOINTS), 2, 9.0, sharex=True)
    for joint, (left, right) in enumerate(axes):
        for signal in ('newton_euler', 'measured', 'lagrange_euler'):
            draw_band(left, found.time, found.bands[signal], joint, STROKES[signal], _INTERVALS)
        for method in ('newton_euler', 'lagrange_euler'):
            draw_band(right, found.time, found.bands['error_' + method], joint, STROKES[method],
                      _INTERVALS)
        zero_line(right)
        rms = found.methods['lagrange_euler'].rms[joint]
        right.set_title(f'RMS {rms:.3f} N m', loc='right', pad=2, color=FAINT, fontsize=9)
        frame(left, f'{JOINTS[joint]} [N m]')
        frame(right, '')
    axes[0, 0].set_title('effort', loc='left')
    axes[0, 1].set_title('measured − predicted', loc='left')
    for axis in axes[-1]:
        axis.set_xlabel('time [s]')
        axis.set_xlim(0.0, min(found.time[-1], _SHOWN * PERIODS[trajectory]))
    figure.align_ylabels(axes[:, 0])
    legend(figure, axes[0, 0])
    write(figure, path)

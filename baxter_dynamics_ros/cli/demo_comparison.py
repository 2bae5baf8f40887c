"""Comparison of measured and predicted effort in the demo: a table and a figure."""

import io
from pathlib import Path

from matplotlib.figure import Figure
import numpy as np
from sensor_msgs.msg import JointState

from .terminal import say, show_joints
from ..estimation.joint_selection import JointSelector
from ..estimation.settings import PredictorSettings
from ..files import write_file
from ..model.arrays import Array, Indices
from ..model.joints import JOINTS
from ..nodes.messages import from_field, stamp_ns
from ..report.drawing import frame, styled, zero_line

_COLORS = {'measured': '#9aa5b1', 'predicted': '#0b6e99', 'residual': '#b3401f',
           'first difference': '#e4d3c8'}
Signals = dict[str, tuple[Array, Array]]  # name -> time (n,) [s], values (n, 7) [N m]


def compare(side: str, measured: list[JointState], predicted: list[JointState],
            residual: list[JointState]) -> Signals:
    """Return the signals of one arm in joint states and predictions, and print their RMS."""
    effort = {stamp_ns(m.header): from_field(m.effort) for m in predicted}
    pairs = [(stamp_ns(m.header), effort[stamp_ns(m.header)], from_field(m.effort))
             for m in residual if stamp_ns(m.header) in effort]
    stamps, prediction, error = (np.array(column) for column in zip(*pairs))
    raw_stamps, difference = _first_difference(measured, side)
    time, raw_time = ((each - stamps[0]) * 1e-9 for each in (stamps, raw_stamps))
    say(f'{len(time)} predictions in {time[-1]:.1f} s. RMS [N m]; residual = measured - '
        "predicted effort; last column: residual with the paper's first difference as "
        'acceleration')
    signals = {'measured': (time, prediction + error), 'predicted': (time, prediction),
               'residual': (time, error), 'first difference': (raw_time, difference)}
    show_joints({name: _rms(values) for name, (_, values) in signals.items()})
    return signals


def plot(path: Path, side: str, signals: Signals) -> None:
    """Save a figure with a row per joint; raise BaxterDynamicsError if it cannot be saved."""
    with styled():
        figure = Figure(figsize=(12, 10), layout='constrained')
        figure.suptitle(f"Fake Baxter, {side} arm, the paper's trajectory 3(a)")
        axes = figure.subplots(len(JOINTS), 2, sharex=True)
        rms = _rms(signals['residual'][1])
        limits = 2.5 * np.abs(signals['residual'][1]).max(axis=0)  # cut off the first difference
        for i, (joint, row) in enumerate(zip(JOINTS, axes)):
            for axis, names in zip(row, (('measured', 'predicted'),
                                         ('first difference', 'residual'))):
                for name, width in zip(names, (2.0, 1.2)):
                    time, values = signals[name]
                    axis.plot(time, values[:, i], color=_COLORS[name], lw=width, label=name)
            zero_line(row[1])
            frame(row[0], f'{joint} [N m]')
            frame(row[1], f'RMS {rms[i]:.3f}', (-limits[i], limits[i]))
        for axis, name in zip(axes[0], ('effort', 'measured - predicted')):
            axis.set_title(name, loc='left')
            axis.legend(loc='lower right', bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
        for axis in axes[-1]:
            axis.set_xlabel('time [s]')
        buffer = io.BytesIO()
        figure.savefig(buffer, format=path.suffix[1:], dpi=85)
    write_file(path, buffer.getvalue())


def _rms(values: Array) -> Array:
    return np.sqrt(np.mean(values ** 2, axis=0))


def _first_difference(messages: list[JointState], side: str) -> tuple[Indices, Array]:
    """Return stamps [ns] and residuals (m, 7) with the paper's qdd = (qd - previous qd) / dt."""
    selector = JointSelector(side)
    model = PredictorSettings(arm=side).model
    readings = ((stamp_ns(message.header), selector.read(message.name, *map(from_field, (
        message.position, message.velocity, message.effort)))) for message in messages)
    stamps, q, qd, effort = (np.array(column) for column in zip(*(
        (stamp, *reading) for stamp, reading in readings if isinstance(reading, tuple))))
    qdd = np.diff(qd, axis=0) / (np.diff(stamps) * 1e-9)[:, None]
    q, qd = q[1:], qd[1:]
    tau = model.arm.inverse_dynamics(q, qd, qdd)
    return stamps[1:], effort[1:] - model.effort_model.effort(tau, q, qd, qdd)

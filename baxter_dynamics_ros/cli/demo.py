"""
Run the predictor on a fake Baxter and show the residual.

Compares the predicted with the measured effort, calls the services gravity_torques and
inverse_dynamics, and saves a figure.
"""

import argparse
import io
import os
from pathlib import Path
import time
from typing import Any, TYPE_CHECKING

import numpy as np

from .options import add, number, output_path
from .processes import NodeProcess
from .terminal import complain, progress, say, show_table
from ..estimation.settings import PredictorSettings
from ..estimation.stream import JointSelector
from ..files import write_file
from ..model import Array, BaxterDynamicsError, Indices, JOINTS, rms

if TYPE_CHECKING:
    from .listener import Listener, Received

# Separate from a real robot that may be on the same network.
NAMESPACE = '/baxter_dynamics_demo'
_FIRST_PREDICTION = 20.0  # timeout [s]
_FIELDS = ('torque', 'inertial', 'coriolis', 'gravity', 'actuator_effort')  # of the services
_COLORS = {'measured': '#9aa5b1', 'predicted': '#0b6e99', 'residual': '#b3401f',
           'first difference': '#e4d3c8'}
_Signals = dict[str, tuple[Array, Array]]  # name -> time (n,) [s], values (n, 7) [N m]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics demo``."""
    parser.add_argument('--duration', type=number(2, 3600, 'seconds'), default=20.0,
                        metavar='SECONDS',
                        help='duration of the comparison (default: %(default)g)')
    parser.add_argument('--output', default='baxter_dynamics_demo.png', metavar='FILE',
                        help='figure to save: .png, .pdf or .svg (default: %(default)s)')
    parser.add_argument('--panel', action='store_true',
                        help='show the panel in the web browser instead of comparing')
    add(parser, '--arm')


def main(args: argparse.Namespace) -> int:
    """Run the demo and print the comparison."""
    figure = output_path('--output', args.output, ('.png', '.pdf', '.svg'))
    from .listener import Listener
    from ..nodes import topics
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    common = ['--ros-args', '-r', f'__ns:={NAMESPACE}', '-r',
              f'{topics.JOINT_STATES}:={NAMESPACE}/joint_states', '-p', f'arm:={args.arm}']
    with Listener('observer', NAMESPACE) as listener, \
            NodeProcess('fake_baxter', common) as baxter, \
            NodeProcess('torque_predictor', common) as predictor:
        received = [listener.joint_states(topic) for topic in (
            'joint_states', f'torque_predictor/{topics.PREDICTED_EFFORT}',
            f'torque_predictor/{topics.EFFORT_RESIDUAL}')]
        _await_prediction(listener, received[1], [baxter, predictor])
        if args.panel:
            return _show_panel(listener)
        for states in received:
            states.clear()
        with progress(args.duration) as update:
            start = time.monotonic()
            listener.wait(lambda: update(time.monotonic() - start, 'recording the residual'),
                          args.duration)
        if len(received[2]) < 2:
            raise _failure([predictor], 'predictions arrived, but no residuals')
        signals = _compare(args.arm, *received)
        _call_services(listener)
    _plot(figure, args.arm, signals)
    say(f'figure: {figure}')
    return 0


def _await_prediction(listener: 'Listener', predicted: 'list[Received]',
                      processes: list[NodeProcess]) -> None:
    def ended() -> list[NodeProcess]:
        return [process for process in processes if process.poll() is not None]
    listener.wait(lambda: predicted or ended(), _FIRST_PREDICTION)
    if not predicted:
        reasons = [f'{each.executable} ended with exit code {each.poll()}' for each in ended()]
        raise _failure(ended() or processes, ' and '.join(reasons) or
                       f'no prediction within {_FIRST_PREDICTION:.0f} s')


def _failure(processes: list[NodeProcess], reason: str) -> BaxterDynamicsError:
    """Print the output of the processes, and return the error."""
    for process in processes:
        for line in process.output.strip().splitlines():
            complain(f'{process.executable}: {line}')
    return BaxterDynamicsError(reason)


def _show_panel(listener: 'Listener') -> int:
    from .main import needs, parse
    with needs('panel'):
        from .panel_page import serve
    listener.unsubscribe()  # their lists would grow
    serve(listener, parse(['panel', '--node', f'{NAMESPACE}/torque_predictor',
                           '--topic', f'{NAMESPACE}/joint_states']))
    return 0


def _call_services(listener: 'Listener') -> None:
    try:
        from baxter_dynamics_interfaces.srv import GravityTorques, InverseDynamics
    except ImportError:
        say('services: not available, because baxter_dynamics_interfaces is not installed: '
            'pip install ./baxter_dynamics_interfaces')
        return
    for name, kind in ('gravity_torques', GravityTorques), ('inverse_dynamics', InverseDynamics):
        answer: Any = listener.call(kind, f'torque_predictor/{name}')
        if answer is None or not answer.success:
            reason = 'no answer' if answer is None else answer.message
            raise BaxterDynamicsError(f'service {name}: {reason}')
        say(f'service {name} [N m]: {answer.message}')
        fields = {field: getattr(answer, field) for field in _FIELDS if hasattr(answer, field)}
        show_table(('', *JOINTS), [(field, *getattr(values, 'effort', values))
                                   for field, values in fields.items()])


def _compare(side: str, measured: 'list[Received]', predicted: 'list[Received]',
             residual: 'list[Received]') -> _Signals:
    """Return the signals of one arm in joint states and predictions, and print their RMS."""
    effort = {stamp: values for stamp, *_, values in predicted}
    stamps, prediction, error = (np.array(column) for column in zip(*(
        (stamp, effort[stamp], values) for stamp, *_, values in residual if stamp in effort)))
    raw_stamps, difference = _first_difference(measured, side)
    time, raw_time = ((each - stamps[0]) * 1e-9 for each in (stamps, raw_stamps))
    say(f'{len(time)} predictions in {time[-1]:.1f} s. RMS [N m]; residual = measured - '
        "predicted effort; last column: residual with the paper's first difference as "
        'acceleration')
    signals = {'measured': (time, prediction + error), 'predicted': (time, prediction),
               'residual': (time, error), 'first difference': (raw_time, difference)}
    show_table(('joint', *signals), zip(JOINTS, *(rms(values) for _, values in signals.values())))
    return signals


def _first_difference(states: 'list[Received]', side: str) -> tuple[Indices, Array]:
    """Return stamps [ns] and residuals (m, 7) with the paper's qdd = (qd - previous qd) / dt."""
    model, selector = PredictorSettings(arm=side).model, JointSelector(side)
    readings = ((stamp, selector.read(names, *fields)) for stamp, names, *fields in states)
    stamps, q, qd, effort = (np.array(column) for column in zip(*(
        (stamp, *reading) for stamp, reading in readings if isinstance(reading, tuple))))
    qdd = np.diff(qd, axis=0) / (np.diff(stamps) * 1e-9)[:, None]
    q, qd = q[1:], qd[1:]
    tau = model.arm.inverse_dynamics(q, qd, qdd)
    return stamps[1:], effort[1:] - model.effort_model.effort(tau, q, qd, qdd)


def _plot(path: Path, side: str, signals: _Signals) -> None:
    """Save a figure with a row per joint; raise BaxterDynamicsError if it cannot be saved."""
    from matplotlib.figure import Figure
    from ..report.drawing import frame, styled, zero_line
    with styled():
        figure = Figure(figsize=(12, 10), layout='constrained')
        figure.suptitle(f"Fake Baxter, {side} arm, the paper's trajectory 3(a)")
        axes = figure.subplots(len(JOINTS), 2, sharex=True)
        _, residual = signals['residual']
        residual_rms = rms(residual)
        limits = 2.5 * np.abs(residual).max(axis=0)  # cut off the first difference
        for i, (joint, row) in enumerate(zip(JOINTS, axes)):
            for axis, names in zip(row, (('measured', 'predicted'),
                                         ('first difference', 'residual'))):
                for name, width in zip(names, (2.0, 1.2)):
                    time, values = signals[name]
                    axis.plot(time, values[:, i], color=_COLORS[name], lw=width, label=name)
            zero_line(row[1])
            frame(row[0], f'{joint} [N m]')
            frame(row[1], f'RMS {residual_rms[i]:.3f}', (-limits[i], limits[i]))
        for axis, name in zip(axes[0], ('effort', 'measured - predicted')):
            axis.set_title(name, loc='left')
            axis.legend(loc='lower right', bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
        for axis in axes[-1]:
            axis.set_xlabel('time [s]')
        buffer = io.BytesIO()
        figure.savefig(buffer, format=path.suffix[1:], dpi=85)
    write_file(path, buffer.getvalue())

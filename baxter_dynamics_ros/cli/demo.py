"""demo: a fake Baxter and the predictor, observed through their topics."""

from __future__ import annotations

import argparse
import os
import time
from typing import Any, TYPE_CHECKING

from .options import add_arm, number, output_file
from .processes import NodeProcess
from .terminal import complain, progress, say, show_table
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import JOINTS

if TYPE_CHECKING:
    from .listener import Listener

# Separate from a real robot that may be on the same network.
NAMESPACE = '/baxter_dynamics_demo'
_FIRST_PREDICTION = 20.0  # timeout [s]

DESCRIPTION = (
    'Start a fake Baxter and the predictor as separate processes, compare the predicted with '
    'the measured effort, call both services, and save a figure.')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics demo``."""
    parser.add_argument('--duration', type=number(2, 3600, 'seconds'), default=20.0,
                        metavar='SECONDS',
                        help='duration of the comparison (default: %(default)g)')
    parser.add_argument('--output', default='baxter_dynamics_demo.png', metavar='FILE',
                        help='figure to save: .png, .pdf or .svg (default: %(default)s)')
    parser.add_argument('--panel', action='store_true',
                        help='show both in the web browser until Ctrl-C instead of comparing them')
    add_arm(parser)


def main(args: argparse.Namespace) -> int:
    """Run the demo and print the comparison."""
    from sensor_msgs.msg import JointState
    from .demo_comparison import compare, plot
    from .listener import Listener
    from ..nodes import topics
    figure = output_file('--output', args.output, ('.png', '.pdf', '.svg'))
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    common = ['--ros-args', '-r', f'__ns:={NAMESPACE}', '-r',
              f'{topics.JOINT_STATES}:={NAMESPACE}/joint_states', '-p', f'arm:={args.arm}']
    with Listener('observer', NAMESPACE) as listener, \
            NodeProcess('fake_baxter', common) as baxter, \
            NodeProcess('torque_predictor', common) as predictor:
        measured, predicted, residual = received = [
            listener.collect(JointState, topic) for topic in (
                'joint_states', f'torque_predictor/{topics.PREDICTED_EFFORT}',
                f'torque_predictor/{topics.EFFORT_RESIDUAL}')]
        _await_prediction(listener, predicted, [baxter, predictor])
        if args.panel:
            return _show_panel(listener)
        for messages in received:
            messages.clear()
        _record(listener, args.duration)
        if len(residual) < 2:
            _print_output([predictor])
            raise BaxterDynamicsError('predictions arrived, but no residuals')
        signals = compare(args.arm, measured, predicted, residual)
        _call_services(listener)
    plot(figure, args.arm, signals)
    say(f'figure: {figure}')
    return 0


def _await_prediction(listener: Listener, predicted: list[Any],
                      processes: list[NodeProcess]) -> None:
    def ended() -> list[NodeProcess]:
        return [process for process in processes if process.exit_code is not None]
    listener.wait(lambda: predicted or ended(), _FIRST_PREDICTION)
    if not predicted:
        _print_output(ended() or processes)
        raise BaxterDynamicsError(
            ' and '.join(f'{process.executable} ended with exit code {process.exit_code}'
                         for process in ended())
            or f'no prediction within {_FIRST_PREDICTION:.0f} s')


def _show_panel(listener: Listener) -> int:
    from .main import needs, parse
    with needs('panel'):
        from .panel_page import serve
    serve(listener, parse(['panel', '--node', f'{NAMESPACE}/torque_predictor',
                           '--topic', f'{NAMESPACE}/joint_states']))
    return 0


def _print_output(processes: list[NodeProcess]) -> None:
    for process in processes:
        for line in process.output.strip().splitlines():
            complain(f'{process.executable}: {line}')


def _record(listener: Listener, duration: float) -> None:
    start = time.monotonic()
    with progress(duration) as update:
        while (elapsed := time.monotonic() - start) < duration:
            listener.wait(lambda: False, min(0.1, duration - elapsed))
            update(elapsed, 'recording the residual')


def _call_services(listener: Listener) -> None:
    """Call both services and print their answers."""
    try:
        from baxter_dynamics_interfaces.srv import GravityTorques, InverseDynamics
    except ImportError:
        say('services: not available, because baxter_dynamics_interfaces is not installed: '
            'pip install ./baxter_dynamics_interfaces')
        return
    for name, kind in ('gravity_torques', GravityTorques), ('inverse_dynamics', InverseDynamics):
        answer = listener.call(kind, f'torque_predictor/{name}')
        if answer is None or not answer.success:
            reason = 'no answer' if answer is None else answer.message
            raise BaxterDynamicsError(f'service {name}: {reason}')
        fields = {field: getattr(answer, field) for field in (
            'torque', 'inertial', 'coriolis', 'gravity', 'actuator_effort')
            if hasattr(answer, field)}
        say(f'service {name} [N m]: {answer.message}')
        show_table(('', *JOINTS), [
            (field, *(f'{x:.3f}' for x in getattr(values, 'effort', values)))
            for field, values in fields.items()])

"""demo: a fake Baxter and the predictor, observed through their topics."""

import argparse
import os
import signal
import time
from typing import Any

import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import JointState

from .console import progress, show_table
from .options import add_arm, number
from .outputs import output_file
from .plots import plot_effort
from .printing import complain, say
from .processes import NodeProcess
from ..estimation.joint_selection import JointSelector
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array, Indices
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import JOINTS
from ..nodes import topics
from ..nodes.messages import from_field, stamp_ns

# Separate from a real robot that may be on the same network.
NAMESPACE = '/baxter_dynamics_demo'
_FIRST_PREDICTION = 20.0  # timeout [s]
_SERVICE = 10.0  # timeout [s]


class Observer(Node):
    """Subscriber to the topics of the demo; keeps all messages."""

    def __init__(self) -> None:
        super().__init__('observer', namespace=NAMESPACE)
        self.measured: list[JointState] = []
        self.predicted: list[JointState] = []
        self.residual: list[JointState] = []
        for topic, messages, qos in (
                ('joint_states', self.measured, topics.SUBSCRIPTION_QOS),
                ('torque_predictor/predicted_effort', self.predicted, topics.PUBLISHER_QOS),
                ('torque_predictor/effort_residual', self.residual, topics.PUBLISHER_QOS)):
            self.create_subscription(JointState, topic, messages.append, qos)

    def call(self, kind: type[Any], name: str) -> Any:
        """Return the answer of a service to an empty request; None if there is none."""
        client = self.create_client(kind, 'torque_predictor/' + name)
        if not client.wait_for_service(timeout_sec=_SERVICE):
            return None
        future = client.call_async(kind.Request())
        rclpy.spin_until_future_complete(self, future, timeout_sec=_SERVICE)
        return future.result()


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
    add_arm(parser)


def main(args: argparse.Namespace) -> int:
    """Run the demo and print the comparison."""
    figure = output_file('--output', args.output, ('.png', '.pdf', '.svg'))
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    common = ['--ros-args', '-r', f'__ns:={NAMESPACE}', '-r',
              f'{topics.JOINT_STATES}:={NAMESPACE}/joint_states', '-p', f'arm:={args.arm}']
    rclpy.init(args=[])
    try:
        with NodeProcess('fake_baxter', common) as baxter, \
                NodeProcess('torque_predictor', common) as predictor:
            observer = Observer()
            _await_prediction(observer, [baxter, predictor])
            _watch(observer, args.duration)
            answers = _call_services(observer)
            if len(observer.residual) < 2:
                _print_output([predictor])
                raise BaxterDynamicsError('predictions arrived, but no residuals')
    except ExternalShutdownException:
        return 128 + signal.SIGTERM
    finally:
        rclpy.try_shutdown()
    signals = _signals(observer, args.arm)
    _print_comparison(signals)
    _print_services(answers)
    plot_effort(figure, signals, f"Fake Baxter, {args.arm} arm, the paper's trajectory 3(a)")
    say(f'figure: {figure}')
    return 0


def _await_prediction(observer: Observer, processes: list[NodeProcess]) -> None:
    limit = time.monotonic() + _FIRST_PREDICTION
    while not observer.predicted:
        rclpy.spin_once(observer, timeout_sec=0.1)
        for process in processes:
            if process.exit_code is not None:
                _print_output([process])
                raise BaxterDynamicsError(
                    f'{process.executable} ended with exit code {process.exit_code}')
        if time.monotonic() > limit:
            _print_output(processes)
            raise BaxterDynamicsError(f'no prediction within {_FIRST_PREDICTION:.0f} s, '
                                      f'{len(observer.measured)} joint states received')


def _print_output(processes: list[NodeProcess]) -> None:
    for process in processes:
        for line in process.output.strip().splitlines():
            complain(f'{process.executable}: {line}')


def _watch(observer: Observer, duration: float) -> None:
    for messages in (observer.measured, observer.predicted, observer.residual):
        messages.clear()
    start = time.monotonic()
    with progress(duration) as update:
        while (elapsed := time.monotonic() - start) < duration:
            rclpy.spin_once(observer, timeout_sec=0.1)
            update(elapsed, 'recording the residual')


def _call_services(observer: Observer) -> dict[str, Any]:
    try:
        from baxter_dynamics_interfaces.srv import GravityTorques, InverseDynamics
    except ImportError:
        return {}
    return {'gravity_torques': observer.call(GravityTorques, 'gravity_torques'),
            'inverse_dynamics': observer.call(InverseDynamics, 'inverse_dynamics')}


def _signals(observer: Observer, arm: str) -> dict[str, tuple[Array, Array]]:
    """Return time (n,) [s] and values (n, 7) [N m] of each signal."""
    predicted = {stamp_ns(m.header): from_field(m.effort) for m in observer.predicted}
    pairs = [(stamp_ns(m.header), predicted[stamp_ns(m.header)], from_field(m.effort))
             for m in observer.residual if stamp_ns(m.header) in predicted]
    stamps, effort, residual = (np.array(column) for column in zip(*pairs))
    newest, difference = _first_difference(observer.measured, arm)
    time = (stamps - stamps[0]) * 1e-9
    return {'measured': (time, effort + residual), 'predicted': (time, effort),
            'residual': (time, residual),
            'first difference': ((newest - stamps[0]) * 1e-9, difference)}


def _first_difference(messages: list[JointState], arm: str) -> tuple[Indices, Array]:
    """Return stamps [ns] and residuals (m, 7) with the paper's qdd = (qd - previous qd) / dt."""
    selector = JointSelector(arm)
    settings = PredictorSettings({'arm': arm})
    readings = ((stamp_ns(message.header), selector.read(message.name, *map(from_field, (
        message.position, message.velocity, message.effort)))) for message in messages)
    stamps, q, qd, effort = (np.array(column) for column in zip(*(
        (stamp, *reading) for stamp, reading in readings if isinstance(reading, tuple))))
    qdd = np.diff(qd, axis=0) / (np.diff(stamps) * 1e-9)[:, None]
    q, qd = q[1:], qd[1:]
    tau = settings.arm.inverse_dynamics(q, qd, qdd)
    return stamps[1:], effort[1:] - settings.effort_model.effort(tau, q, qd, qdd)


def _print_comparison(signals: dict[str, tuple[Array, Array]]) -> None:
    time = signals['residual'][0]
    say(f'{len(time)} predictions in {time[-1]:.1f} s. RMS [N m]; residual = measured - predicted '
        'effort;', "last column: residual with the paper's first difference as acceleration")
    rms = [np.sqrt(np.mean(values ** 2, axis=0)) for _, values in signals.values()]
    show_table(('joint', *signals), [(joint, *(f'{column[i]:.3f}' for column in rms))
                                     for i, joint in enumerate(JOINTS)])


def _print_services(answers: dict[str, Any]) -> None:
    if not answers:
        say('services: not available, because baxter_dynamics_interfaces is not installed: '
            'pip install ./baxter_dynamics_interfaces')
        return
    for name, answer in answers.items():
        if answer is None or not answer.success:
            reason = 'no answer' if answer is None else answer.message
            raise BaxterDynamicsError(f'service {name}: {reason}')
        fields = ({'gravity': answer.gravity.effort} if name == 'gravity_torques' else
                  {'torque': answer.torque.effort, 'inertial': answer.inertial,
                   'coriolis': answer.coriolis, 'gravity': answer.gravity})
        fields['actuator_effort'] = answer.actuator_effort
        say(f'service {name} [N m]: {answer.message}')
        show_table(('', *JOINTS), [(field, *(f'{value:.3f}' for value in values))
                                   for field, values in fields.items()])

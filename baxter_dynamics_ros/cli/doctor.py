"""
Check the chain from the robot to the residual.

Prints the finding of each step and, if it fails, a remedy. The exit code is 0 only if all steps
pass. The robot is not commanded.
"""

import argparse
from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import chain
import os
import time
from typing import Any, NamedTuple, TYPE_CHECKING

import numpy as np

from .options import add
from .terminal import say
from ..estimation.settings import PredictorSettings
from ..model import Array, joint_names, JOINTS, rms, S1, SIDES
from ..ros1.subscriber import Subscriber
from ..ros1.wire import JointState, Master, resolve, Ros1Error, TYPE

if TYPE_CHECKING:
    from .listener import Listener

_PATIENCE = 5.0  # [s] for discovery, connections and the first message
_LOOK = 3.0  # [s] of joint states and residuals to check
_LARGEST_OFFSET = 15.0  # of s1 [N m]; uncalibrated robots have up to 6, or about 30
_QUANTA = (3.745e-4, 3.927e-4)  # steps of velocity of two generations of firmware [rad/s]
_SLOW = 0.04  # velocity below which multiples of the two differ clearly [rad/s]


class Check(NamedTuple):
    """Result of a step: finding and, where it failed, remedy."""

    name: str
    passed: bool
    found: str
    remedy: str = ''


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics doctor``."""
    parser.add_argument('uri', nargs='?', metavar='URI',
                        help="the robot's ROS 1 master, such as http://011303P0017.local:11311 "
                        '(default: check the ROS 2 side only)')
    add(parser, '--topic')


def main(args: argparse.Namespace) -> int:
    """Print the checks; return 0 if all pass."""
    failed = False
    for check in chain(robot_checks(args.uri, args.topic) if args.uri else (),
                       ros2_checks(args.topic)):
        remedy = '' if check.passed else f': {check.remedy}'
        say(f'{"ok" if check.passed else "FAIL":6}{check.name:13}{check.found}{remedy}')
        failed |= not check.passed
    return int(failed)


def robot_checks(uri: str, topic: str) -> Iterator[Check]:
    """Yield the checks of the robot with a ROS 1 master in order; a network error ends them."""
    states: list[JointState] = []  # of all publishers
    notes: list[str] = []
    try:
        yield from _network(Master(uri, '/doctor'), topic)
        with closing(Subscriber(uri, [topic], lambda topic, source, state, arrival_ns:
                                states.append(state), notes.append, '/doctor')) as subscriber:
            yield from _connections(subscriber, topic, states, notes)
            if states:
                states.clear()
                yield from _stream(subscriber, topic)
                yield from _contents(states.copy())
    except Ros1Error as error:
        yield Check(error.stage, False, error.cause, error.remedy)


def _network(master: Master, topic: str) -> Iterator[Check]:
    yield Check('name', True, f'{master.host} is {resolve(master.host)}')
    local = master.locate()
    yield Check('route', True, f'port {master.port} is open; this machine is {local} from there')
    publishers, _ = master.system_state()
    nodes = {node for names in publishers.values() for node in names}
    yield Check('master', True, f'{len(publishers)} topics of {len(nodes)} nodes')
    types = master.ask('getTopicTypes', parse=dict)
    if topic not in publishers:
        others = sorted(name for name in publishers if types.get(name) == TYPE)
        raise Ros1Error('topic', f'{topic} is not published',
                        f'give one of {", ".join(others)} as --topic' if others else
                        'has the robot finished starting?')
    yield Check('topic', True, f'{topic} is {types.get(topic, "of an unknown type")}')


def _connections(subscriber: Subscriber, topic: str, states: list[JointState],
                 notes: list[str]) -> Iterator[Check]:
    _wait(lambda: bool(connections := subscriber.connections(topic)) and all(
        each.stream for each in connections))
    connected = [f'{each.publisher} at {each.uri}' for each in subscriber.connections(topic)
                 if each.stream]
    if connected:
        yield Check('publishers', True, ', '.join(connected)
                    + ''.join(f' ({note})' for note in notes))
    _wait(lambda: bool(subscriber.is_called))
    if subscriber.is_called:
        yield Check('address', True, 'the master reaches this machine')
    _wait(lambda: bool(states))
    problems = subscriber.problems(topic)
    yield from (Check(each.stage, False, each.cause, each.remedy) for each in problems)
    if states:
        names = states[0].name
        yield Check('message', True, f'{len(names)} joints, {names[0]} ... {names[-1]}' if names
                    else 'without joints')
    elif not problems:
        raise Ros1Error('stream', f'nothing arrives on {topic}', 'is the publisher stopped?')


def _stream(subscriber: Subscriber, topic: str) -> Iterator[Check]:
    for source in subscriber.sources(topic):
        source.close_period(1.0)
    before = sum(source.lost for source in subscriber.sources(topic))
    begin = time.monotonic()
    time.sleep(_LOOK)
    seconds = time.monotonic() - begin
    sources = subscriber.sources(topic)
    for source in sources:
        source.close_period(seconds)
    yield Check('rate', any(source.rate > 0.0 for source in sources), ', '.join(
        f'{source.rate:.1f} Hz from {source.publisher}' for source in sources),
        'nothing has arrived: is the publisher stopped?')
    lost = sum(source.lost for source in sources) - before
    yield Check('lost', not lost and not subscriber.malformed,
                f'{lost} messages lost and {subscriber.malformed} malformed in {seconds:.0f} s',
                'use a cable instead of wireless, and reduce the load of both machines')
    yield Check('clock', True, "this machine's minus the robot's: " + ', '.join(
        f'{source.clock.offset_ns * 1e-9:+.3f} s, jitter of arrival {source.jitter * 1e3:.1f} ms'
        for source in sources))


def _contents(states: list[JointState]) -> Iterator[Check]:
    names = {name for state in states for name in state.name}
    arms = [side for side in SIDES if names.issuperset(joint_names(side))]
    grippers = [side for side in SIDES if any(
        name.startswith((f'{side}_gripper', f'{side[0]}_gripper')) for name in names)]
    yield Check('arms', bool(arms), f'arms: {", ".join(arms) or "none"}; grippers: '
                f'{", ".join(grippers) or "none"}',
                f'expected the joints of an arm, such as {joint_names("right")[0]}')
    for side in arms:
        q, qd, effort = _samples(states, joint_names(side))
        yield _effort(side, q, effort)
        yield _firmware(side, qd)


def _samples(states: list[JointState], joints: tuple[str, ...]) -> Array:
    """Return position, velocity and effort (3, n, 7) of one arm; NaN where a field is missing."""
    rows = []
    for state in states:
        if set(state.name).issuperset(joints):
            index = [state.name.index(joint) for joint in joints]
            rows.append([[field[i] if len(field) == len(state.name) else np.nan for i in index]
                         for field in (state.position, state.velocity, state.effort)])
    return np.array(rows).swapaxes(0, 1)


def _effort(side: str, q: Array, effort: Array) -> Check:
    """Check whether the measured effort (n, 7) [N m] fits an arm at positions q (n, 7) [rad]."""
    name = f'{side} effort'
    unusable = [field for field, values in (('position', q), ('effort', effort))
                if not np.isfinite(values).all()]
    if unusable:
        return Check(name, False, f'{" and ".join(unusable)} missing or not finite',
                     'a simulator? The residual needs measured effort; predictions do not')
    if not effort.any():
        return Check(name, False, 'zero at all joints', 'a simulator? Its effort is not measured; '
                     'on a robot, restart it')
    model = PredictorSettings(arm=side).model
    static = model.effort_model.effort(model.arm.gravity(q), q, 0.0 * q, 0.0 * q)
    others = np.arange(len(joint_names(side))) != S1  # which may have an offset
    if (effort * static)[:, others].sum() < 0.0:
        return Check(name, False, 'has the opposite sign of the torque that holds the arm',
                     'effort must have the sign of M qdd + C qd + G; correct the publisher')
    offset = float(np.median(effort[:, S1] - static[:, S1]))
    return Check(name, abs(offset) < _LARGEST_OFFSET,
                 f'plausible, offset at s1 {offset:+.1f} N m',
                 'too large for free motion: if nothing holds or loads the arm, s1 has an offset '
                 'particular to this robot: run baxter_dynamics calibrate')


def _firmware(side: str, qd: Array) -> Check:
    """Report the generation of firmware, by the smallest step of the velocity (n, 7) [rad/s]."""
    slow = qd[(np.abs(qd) < _SLOW) & (qd != 0.0)]
    steps = [quantum for quantum in _QUANTA if len(slow) and np.sqrt(np.mean(
        (slow / quantum - np.round(slow / quantum)) ** 2)) < 0.05]
    found = (f'of the generation with velocity steps of {steps[0]:.3e} rad/s' if len(steps) == 1
             else 'not recognised by the steps of the velocity')
    return Check(f'{side} arm', True, f'firmware {found}')


def _wait(condition: Callable[[], bool]) -> None:
    limit = time.monotonic() + _PATIENCE
    while not condition() and time.monotonic() < limit:
        time.sleep(0.05)


def ros2_checks(topic: str) -> Iterator[Check]:
    """Yield the checks of ROS 2 in order; a failure ends them."""
    try:
        from diagnostic_msgs.msg import DiagnosticArray
        from rclpy.utilities import get_rmw_implementation_identifier
        from .listener import Listener
        from ..nodes import topics
    except ImportError as error:
        yield Check('ROS 2', False, str(error), 'install the ros extra, pip install ".[ros]", or '
                    'source the setup file of your ROS 2')
        return
    with Listener('doctor') as listener:
        yield Check('ROS 2', True, f'{get_rmw_implementation_identifier()}, domain '
                    f'{os.environ.get("ROS_DOMAIN_ID") or 0}, discovery range '
                    f'{os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")}')
        diagnostics: list[Any] = []
        listener.subscribe(DiagnosticArray, topics.DIAGNOSTICS, diagnostics.append)
        states = listener.joint_states(topic)
        publishers = _publishers(listener, topic)
        yield publishers
        if publishers.passed:
            found = listener.wait(lambda: states, _PATIENCE)
            yield Check('ROS 2 data', found, f'{"" if found else "no "}joint states on {topic}',
                        'see the diagnostics of its publisher')
            if found:
                yield from _residuals(listener, diagnostics)


def _publishers(listener: 'Listener', topic: str) -> Check:
    listener.wait(lambda: (found := listener.node.get_publishers_info_by_topic(topic)) and all(
        'UNKNOWN' not in each.node_name for each in found), _PATIENCE)
    publishers = [f'{each.node_name} ({each.qos_profile.reliability.name.lower()}, '
                  f'{each.qos_profile.durability.name.lower()})'
                  for each in listener.node.get_publishers_info_by_topic(topic)]
    if not publishers:
        return Check('ROS 2 topic', False, f'{topic} has no publisher',
                     'start joint_state_bridge, or another bridge, with the same ROS_DOMAIN_ID '
                     'and RMW_IMPLEMENTATION')
    return Check('ROS 2 topic', len(publishers) == 1,
                 f'{topic} is published by {", ".join(publishers)}',
                 'joint states may arrive twice: stop all publishers but one')


def _residuals(listener: 'Listener', diagnostics: list[Any]) -> Iterator[Check]:
    from ..nodes.topics import EFFORT_RESIDUAL
    if not listener.wait(listener.predictors, _PATIENCE):
        yield Check('predictor', False, 'no torque_predictor is running',
                    'ros2 launch baxter_dynamics_ros torque_predictor.launch.xml')
    done: set[str] = set()
    while found := listener.predictors() - done:  # some are discovered late
        done.add(name := min(found))
        topic = f'{name}/{EFFORT_RESIDUAL}'
        residuals = listener.joint_states(topic)
        if listener.wait(lambda: residuals, _PATIENCE):
            listener.wait(lambda: False, _LOOK)
            values = rms([effort for *_, effort in residuals])
            yield Check('residual', True, f'RMS on {topic} [N m]: ' + ' '.join(
                f'{joint} {value:.2f}' for joint, value in zip(JOINTS, values)))
        else:
            latest = {status.name: status for array in diagnostics for status in array.status
                      if status.name.startswith(f'{name[1:]}: ')}
            yield Check('residual', False, f'nothing arrives on {topic}', '; '.join(
                status.message for status in latest.values() if status.level != status.OK)
                or 'see the diagnostics of the predictor')

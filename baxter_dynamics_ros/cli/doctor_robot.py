"""Checks of the robot: network, ROS 1 master, and contents of the joint states."""

from collections.abc import Callable, Iterator
import time
from typing import NamedTuple

import numpy as np

from ..estimation.settings import PredictorSettings
from ..model.arrays import Array
from ..model.joints import joint_names, S1, SIDES
from ..ros1 import joint_state
from ..ros1.errors import Ros1Error, Stage
from ..ros1.joint_state import JointState
from ..ros1.network import resolve
from ..ros1.subscriber import Subscriber

_PATIENCE = 5.0  # [s] for connections and the first message
_LOOK = 3.0  # [s] of joint states to check
_LARGEST_OFFSET = 15.0  # of s1 [N m]; uncalibrated robots have up to 6, or about 30
_QUANTA = (3.745e-4, 3.927e-4)  # steps of velocity of two generations of firmware [rad/s]
_SLOW = 0.04  # velocity below which multiples of the two differ clearly [rad/s]


class Check(NamedTuple):
    """Result of a step: finding and, where it failed, remedy."""

    name: str
    passed: bool
    found: str
    remedy: str = ''


def robot_checks(uri: str, topic: str) -> Iterator[Check]:
    """Yield the checks of the robot with a ROS 1 master in order; a network error ends them."""
    states: list[JointState] = []  # of all publishers
    notes: list[str] = []
    try:
        subscriber = Subscriber(uri, [topic], lambda topic, source, state, arrival_ns:
                                states.append(state), notes.append, '/doctor')
        try:
            yield from _network(subscriber, topic)
            subscriber.start()
            yield from _connections(subscriber, topic, states, notes)
            states.clear()
            yield from _stream(subscriber, topic)
            yield from _contents(list(states))
        finally:
            subscriber.stop()
    except Ros1Error as error:
        yield _failure(error)


def _network(subscriber: Subscriber, topic: str) -> Iterator[Check]:
    master = subscriber.master
    host, port = master.endpoint
    yield Check('name', True, f'{host} is {resolve(host)}')
    local = master.locate()
    yield Check('route', True, f'port {port} is open; this machine is {local} from there')
    state = master.system_state()
    nodes = {node for names in state.publishers.values() for node in names}
    yield Check('master', True, f'{len(state.publishers)} topics of {len(nodes)} nodes')
    types = master.topic_types()
    if topic not in state.publishers:
        others = sorted(name for name, kind in types.items()
                        if kind == joint_state.TYPE and name in state.publishers)
        raise Ros1Error(Stage.TOPIC, f'{topic} is not published',
                        f'give one of {", ".join(others)} as --topic' if others else
                        'has the robot finished starting?')
    yield Check('topic', True, f'{topic} is {types.get(topic, "of an unknown type")}')


def _connections(subscriber: Subscriber, topic: str, states: list[JointState],
                 notes: list[str]) -> Iterator[Check]:
    _wait(lambda: bool(connections := subscriber.connections(topic)) and all(
        each.connected for each in connections))
    connections = subscriber.connections(topic)
    yield from (_failure(each.problem) for each in connections if each.problem is not None)
    connected = [f'{each.publisher} at {each.uri}' for each in connections if each.connected]
    if connected:
        yield Check('publishers', True, ', '.join(connected)
                    + ''.join(f' ({note})' for note in notes))
    _wait(lambda: subscriber.is_called is not None)
    is_called = bool(subscriber.is_called)
    yield Check('address', is_called,
                f'the master {"reaches" if is_called else "does not reach"} this machine',
                "set ROS_IP to this machine's address in the robot's network, and open its "
                'firewall')
    _wait(lambda: bool(states))
    if not states:
        raise next(iter(subscriber.problems(topic)), Ros1Error(
            Stage.STREAM, f'nothing arrives on {topic}', 'is the robot enabled?'))
    names = states[0].name
    yield Check('message', True, f'{len(names)} joints, {names[0]} ... {names[-1]}' if names
                else 'without joints')


def _stream(subscriber: Subscriber, topic: str) -> Iterator[Check]:
    """Yield the checks of the messages of some seconds."""
    before = sum(source.lost for source in subscriber.sources(topic))
    for source in subscriber.sources(topic):
        source.close_period(1.0)
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
    """Yield the checks of the contents of joint states."""
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
    """Check whether the measured effort fits an arm at these positions."""
    name = f'{side} effort'
    if not np.isfinite(effort).all():
        return Check(name, False, 'missing or NaN', 'a simulator? The residual needs measured '
                     'effort; predictions do not')
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
    """Report the generation of firmware, by the smallest step of the velocity."""
    slow = qd[(np.abs(qd) < _SLOW) & (qd != 0.0)]
    steps = [quantum for quantum in _QUANTA if len(slow) and np.sqrt(np.mean(
        (slow / quantum - np.round(slow / quantum)) ** 2)) < 0.05]
    found = (f'of the generation with velocity steps of {steps[0]:.3e} rad/s' if len(steps) == 1
             else 'not recognised by the steps of the velocity')
    return Check(f'{side} arm', True, f'firmware {found}')


def _failure(error: Ros1Error) -> Check:
    return Check(error.stage.value, False, error.cause, error.remedy)


def _wait(condition: Callable[[], bool]) -> None:
    limit = time.monotonic() + _PATIENCE
    while not condition() and time.monotonic() < limit:
        time.sleep(0.05)

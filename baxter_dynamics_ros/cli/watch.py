"""watch: a running predictor in the terminal."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
import io
import math
import os
from pathlib import Path
import re
import select
import sys
import termios
import time
import tty
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.validate_full_topic_name import validate_full_topic_name
from rich.console import Console, Group
from rich.live import Live
from rich.text import Text
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from .options import add_arm, number
from .outputs import output_file
from .printing import printable, say, write
from .watch_data import Predictor
from .watch_view import line, view
from ..files import write_file
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import SIDES
from ..nodes import topics

_GRACE = 2.0  # [s] before a missing predictor is reported
_WAIT = 10.0  # [s] that --once waits by default
_ENOUGH = 2.0  # [s] of predictions until rates and diagnostics are known
_LINE_PERIOD = 1.0  # [s]
_BATCH_PERIOD = 0.03  # [s] between two batches of messages
_DISCOVERY_PERIOD = 0.5  # [s]
_PREDICTED = '/' + topics.PREDICTED_EFFORT

_Receive = Callable[[Any, float], None]

DESCRIPTION = (
    'Show the output of a running torque_predictor: measured and predicted effort, residual, '
    'external effort, contact, rates and diagnostics. Prints one line per second where the output '
    'is not a terminal. q or Ctrl-C quits.')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics watch``."""
    parser.add_argument('--node', default='/torque_predictor', metavar='NAME',
                        help='name of the predictor with its namespace (default: %(default)s)')
    add_arm(parser, 'show this arm only', None)
    parser.add_argument('--topic', default='/robot/joint_states', metavar='NAME',
                        help='topic of the joint states (default: %(default)s)')
    parser.add_argument('--rate', type=number(0.2, 30, 'Hz'), default=5.0, metavar='HZ',
                        help='screen updates per second (default: %(default)g)')
    parser.add_argument('--duration', type=number(0.5, 86400, 'seconds'), metavar='SECONDS',
                        help='stop after this time (default: run until Ctrl-C); with --once, the '
                        'longest time to wait (default: 10)')
    parser.add_argument('--once', action='store_true',
                        help='wait for data, print it once and exit; exit code 1 if none arrives')
    parser.add_argument('--save', metavar='FILE.svg',
                        help='save the last view as an SVG figure')


def main(args: argparse.Namespace) -> int:
    """Show a predictor live, as lines or once."""
    figure = output_file('--save', args.save, ('.svg',)) if args.save else None
    duration = args.duration or (_WAIT if args.once else math.inf)
    with _node() as node:
        watcher = _Watcher(node, args.node, args.topic, args.arm)
        try:
            if args.once:
                watcher.once(duration)
            elif sys.stdout is not None and sys.stdout.isatty():
                watcher.live(1.0 / args.rate, duration)
            else:
                watcher.lines(duration)
        finally:  # also after Ctrl-C
            if figure is not None:
                watcher.save(figure)
    return 0


class _Watcher:
    """Subscriptions to the predictors of a name, and their view."""

    def __init__(self, node: Node, name: str, joint_states: str, side: str | None) -> None:
        self._node = node
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        self._name = '/' + name.strip('/')
        self._topic = joint_states
        self._side = side
        self._predictors: dict[str, Predictor] = {}
        self._received = 0  # messages
        self._others: set[str] = set()  # predictors of other names
        self._started = time.monotonic()
        self._discovered = -math.inf  # monotonic time of the last discovery [s]
        self._console = Console(markup=False, highlight=False, emoji=False)
        _validate('--node', self._name)
        _validate('--topic', joint_states)
        self._subscribe(JointState, joint_states, self._to_all(Predictor.receive_joint_state))
        self._subscribe(DiagnosticArray, topics.DIAGNOSTICS,
                        self._to_all(Predictor.receive_diagnostics))

    def live(self, period: float, duration: float) -> None:
        """Redraw the view until the duration has passed or q is pressed."""
        with _keyboard() as is_quit, Live(console=self._console, screen=True,
                                          auto_refresh=False) as screen:
            for now in self._ticks(period, duration, is_quit):
                screen.update(self._view(now), refresh=True)

    def lines(self, duration: float) -> None:
        """Print a line per second and arm."""
        for now in self._ticks(_LINE_PERIOD, duration):
            if now > self._started + 0.5 * _LINE_PERIOD:
                problem = self._problem(now)
                for text in [problem] if problem else [line(x, now) for x in self._shown(now)]:
                    say(f'{time.strftime("%H:%M:%S")} {text}')

    def once(self, duration: float) -> None:
        """Print the view once data has arrived; raise BaxterDynamicsError if none arrives."""
        enough = math.inf
        for now in self._ticks(0.1, duration):
            if any(each.predicted.newest(now) for each in self._shown(now)):
                enough = min(enough, now + _ENOUGH)
            if now >= enough and all(each.diagnostics(now) for each in self._shown(now)):
                break
        if problem := self._missing(now):
            raise BaxterDynamicsError(f'no data within {duration:g} s: {problem}')
        with self._console.capture() as capture:
            self._console.print(self._view(now))
        write(capture.get())

    def save(self, figure: Path) -> None:
        """Save the view as an SVG figure without web fonts."""
        console = Console(record=True, file=io.StringIO(), width=self._console.width,
                          force_terminal=True, color_system='truecolor')
        console.print(self._view(time.monotonic()))
        svg = re.sub(r'@font-face {.*?}\n', '', console.export_svg(title='baxter_dynamics watch'),
                     flags=re.DOTALL)
        write_file(figure, svg)
        say(f'figure: {figure}')

    def _view(self, now: float) -> Group:
        problem = self._problem(now)
        heading = [Text(printable(problem), 'bold yellow')] if problem else []
        return Group(*heading, *(view(each, now) for each in self._shown(now)))

    def _ticks(self, period: float, duration: float,
               is_quit: Callable[[], bool] = lambda: False) -> Iterator[float]:
        """Receive messages; yield the monotonic time [s] every period."""
        due = time.monotonic()
        end = due + duration
        while True:
            if due - self._discovered >= _DISCOVERY_PERIOD:
                self._discovered = due
                self._discover()
            yield (now := time.monotonic())
            if now >= end:
                return
            due = min(max(due + period, now), end)
            while (left := due - time.monotonic()) > 0.0:
                if is_quit():
                    return
                # Messages are received in batches: waiting for each would cost most of a core.
                time.sleep(min(left, _BATCH_PERIOD))
                self._receive(due)

    def _receive(self, until: float) -> None:
        """Receive all waiting messages, until a monotonic time [s] at most."""
        idle = 0  # consecutive calls without a message; one also ends each pass over all topics
        while idle < 2 and time.monotonic() < until:
            before = self._received
            self._executor.spin_once(timeout_sec=0.0)
            idle = idle + 1 if self._received == before else 0

    def _discover(self) -> None:
        """Subscribe to new predictors of our name, also below right/ and left/."""
        namespace, _, name = self._name.rpartition('/')
        ours = {self._name, *(f'{namespace}/{side}/{name}' for side in SIDES)}
        running = {topic.removesuffix(_PREDICTED)
                   for topic, _ in self._node.get_topic_names_and_types()
                   if topic.endswith(_PREDICTED) and self._node.count_publishers(topic)}
        self._others = running - ours
        for found in sorted(running & ours - self._predictors.keys()):
            self._predictors[found] = predictor = Predictor(found)
            for kind, topic, receive in (
                    (JointState, topics.PREDICTED_EFFORT, predictor.receive_prediction),
                    (JointState, topics.EFFORT_RESIDUAL, predictor.residual.receive),
                    (JointState, topics.EXTERNAL_EFFORT, predictor.external.receive),
                    (Bool, topics.CONTACT, predictor.receive_contact)):
                self._subscribe(kind, f'{found}/{topic}', receive)

    def _shown(self, now: float) -> list[Predictor]:
        """Return the live predictors; all if none is live."""
        ours = [each for each in self._predictors.values()
                if self._side in (None, each.side) or not each.side]
        return [each for each in ours if each.is_live(now)] or ours

    def _problem(self, now: float) -> str | None:
        """Return what is missing and the remedy; None if predictions arrive."""
        problem = self._missing(now)
        is_starting = problem and now - self._started < _GRACE
        return f'waiting for {self._name}' if is_starting else problem

    def _missing(self, now: float) -> str | None:
        """Return the same, also before everything had time to start."""
        shown = self._shown(now)
        if any(each.predicted.newest(now) for each in shown):
            return None
        if self._predictors and not shown:
            return f'{self._name} does not predict the {self._side} arm: see --arm and --node'
        if not shown:
            others = ', '.join(sorted(self._others))
            return (f'no predictor {self._name} in ROS domain '
                    f'{os.environ.get("ROS_DOMAIN_ID") or 0}: is torque_predictor running with '
                    'the same ROS_DOMAIN_ID?' + (f' Found {others} (--node).' if others else ''))
        reasons = [message for each in shown for _, level, message in each.diagnostics(now)
                   if level]
        return f'no predictions from {self._name}: ' + (
            reasons[0] if reasons else f'are joint states published on {self._topic}?')

    def _to_all(self, receive: Callable[[Predictor, Any, float], None]) -> _Receive:
        def receive_all(message: Any, now: float) -> None:
            for predictor in self._predictors.values():
                receive(predictor, message, now)
        return receive_all

    def _subscribe(self, kind: type, topic: str, receive: _Receive) -> None:
        def receive_and_count(message: Any) -> None:
            self._received += 1
            receive(message, time.monotonic())
        self._node.create_subscription(kind, topic, receive_and_count, topics.SUBSCRIPTION_QOS)


@contextmanager
def _node() -> Iterator[Node]:
    try:
        # Without the signal handlers of rclpy, Ctrl-C raises KeyboardInterrupt.
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        node = Node(f'watch_{os.getpid()}', enable_rosout=False, start_parameter_services=False)
    except RuntimeError as error:  # such as an invalid ROS_DOMAIN_ID
        raise BaxterDynamicsError(f'ROS does not start: {error}') from None
    try:
        yield node
    finally:
        rclpy.try_shutdown()


@contextmanager
def _keyboard() -> Iterator[Callable[[], bool]]:
    """Read single keys without echo; yield a function that returns whether q was pressed."""
    if sys.stdin is None or not sys.stdin.isatty():
        yield lambda: False
        return
    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    try:
        yield lambda: (bool(select.select([descriptor], [], [], 0.0)[0])
                       and b'q' in os.read(descriptor, 100).lower())
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def _validate(option: str, name: str) -> None:
    try:
        validate_full_topic_name(name)
    except InvalidTopicNameException as error:
        raise BaxterDynamicsError(f'{option}: {" ".join(str(error).split())}') from None

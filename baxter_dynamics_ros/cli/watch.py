"""The command that watches a predictor: live in a terminal, as lines, or once."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
import math
import os
from pathlib import Path
import signal
import sys
import time
from types import FrameType

import rclpy
from rclpy.signals import SignalHandlerOptions
from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from .options import add_arm, number
from .outputs import output_file
from .watch_bars import BLOCKS, Glyphs, glyphs
from .watch_listener import Listener
from .watch_terminal import Keys, keys, save_picture, suspension
from .watch_view import Canvas, view
from .watch_words import summary
from ..model.exceptions import BaxterDynamicsError

ONCE_WAITS = 10.0  # [s] by default
_ENOUGH = 1.1  # [s] of messages, after which diagnostics and rates are known, too
_ROBOT = 2.0  # [s] to find the robot, too; it may be on another topic
_LOOK = 0.05  # [s] between two looks at what has come, when nothing is drawn
_LINE_EVERY = 1.0  # [s]


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
    parser.add_argument('--rate', type=number(0.2, 30, 'Hz'), default=10.0, metavar='HZ',
                        help='screen updates per second (default: %(default)g)')
    parser.add_argument('--duration', type=number(0.5, 86400, 'seconds'), metavar='SECONDS',
                        help='stop after this time (default: run until Ctrl-C); with --once, the '
                        'longest time to wait (default: 10)')
    parser.add_argument('--once', action='store_true',
                        help='wait for data, print it once and exit; exit code 1 if none arrives')
    parser.add_argument('--save', metavar='FILE.svg',
                        help='save the last view as an SVG figure')


def main(args: argparse.Namespace) -> int:
    """Watch a predictor."""
    picture = output_file('--save', args.save, ('.svg',)) if args.save else None
    console = Console(highlight=False)
    try:
        with _termination(), _listener(args.node, args.arm, args.topic) as listener:
            watcher = _Watcher(listener, args.arm, console)
            try:
                duration = math.inf if args.duration is None else args.duration
                if args.once:
                    watcher.once(ONCE_WAITS if args.duration is None else args.duration)
                elif (sys.stdout is not None and sys.stdout.isatty()
                        and not console.is_dumb_terminal):
                    watcher.live(1.0 / args.rate, duration)
                else:
                    watcher.lines(duration)
            except (KeyboardInterrupt, _Terminated):
                if not args.once:  # the usual end
                    watcher.save(picture)
                raise
            watcher.save(picture)
    except _Terminated:
        return 128 + signal.SIGTERM
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):  # whoever read our lines has had enough
            return 128 + signal.SIGPIPE
        raise BaxterDynamicsError(f'the output cannot be written ({error.strerror})') from None
    return 0


class _Watcher:
    """What the listener hears, in one of the three forms."""

    def __init__(self, listener: Listener, arm: str | None, console: Console) -> None:
        self._listener = listener
        self._arm = arm
        self._console = console
        self._glyphs = glyphs(console.encoding)

    def live(self, period: float, duration: float) -> None:
        until = time.monotonic() + duration
        with suspension(self._console), keys() as pressed, Live(
                console=self._console, screen=True, auto_refresh=False,
                redirect_stdout=False, redirect_stderr=False) as screen:
            for now in _ticks(period, until, pressed):
                self._listener.listen(now)
                width, height = self._console.size
                screen.update(Group(*self._view(now, width, height)), refresh=True)

    def lines(self, duration: float) -> None:
        start = time.monotonic()
        with keys() as pressed:
            due = start + _LINE_EVERY
            for now in _ticks(_LOOK, start + duration, pressed):
                self._listener.listen(now)
                if now >= due:
                    due += _LINE_EVERY
                    self._print_lines(now)

    def once(self, patience: float) -> None:
        start = time.monotonic()
        predicted = enough = math.inf
        for now in _ticks(_LOOK, start + patience, Keys(None)):
            self._listener.listen(now)
            if self._listener.missing(now) is None:
                predicted = min(predicted, now)
            robot = self._listener.watched.inputs.values()
            if now >= predicted and (now >= predicted + _ROBOT
                                     or any(series.is_live(now) for series in robot)):
                enough = min(enough, now + _ENOUGH)
            if now >= enough:
                break
        now = time.monotonic()
        if missing := self._listener.missing(now):
            raise BaxterDynamicsError(f'nothing within {patience:g} s: {missing}')
        for line in self._view(now, self._console.width, None):
            self._console.print(line, soft_wrap=True)

    def save(self, picture: Path | None) -> None:
        if picture is None:
            return
        now = time.monotonic()
        self._listener.listen(now)
        width = self._console.width
        save_picture(picture, self._view(now, width, None, drawn=BLOCKS), width,
                     'baxter_dynamics watch')
        self._console.print(f'picture: {picture}', soft_wrap=True)

    def _view(self, now: float, width: int, height: int | None,
              drawn: Glyphs | None = None) -> list[Text]:
        title = (f'{self._listener.predictor}  {time.strftime("%H:%M:%S")}'
                 f'  ROS domain {os.environ.get("ROS_DOMAIN_ID") or 0}')
        return view(self._listener.watched, self._arm, title, self._listener.missing(now), now,
                    Canvas(width, height, drawn or self._glyphs))

    def _print_lines(self, now: float) -> None:
        watched = self._listener.watched
        clock = time.strftime('%H:%M:%S')
        lines = [summary(watched, arm, now) for arm in watched.shown(self._arm)]
        if missing := self._listener.missing(now):
            lines = [missing]
        for line in lines:
            print(f'{clock} {line}', flush=True)


def _ticks(period: float, until: float, pressed: Keys) -> Iterator[float]:
    """Yield the monotonic time [s] every period, until it is over or q is pressed."""
    due = time.monotonic()
    while True:
        now = time.monotonic()
        yield now
        if now >= until:
            return
        due = max(due + period, now)  # what is late is not made up for
        if pressed.wait(min(due, until) - time.monotonic()):
            return


class _Terminated(Exception):
    """SIGTERM came."""


@contextmanager
def _termination() -> Iterator[None]:
    """Let SIGTERM end what runs as an exception does, so that the terminal is put right."""
    def end(number: int, frame: FrameType | None) -> None:
        raise _Terminated
    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def _listener(predictor: str, arm: str | None, topic: str) -> Iterator[Listener]:
    try:
        # Without rclpy's own: Ctrl-C is then KeyboardInterrupt, as in the other subcommands.
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        listener = Listener(predictor, arm, topic)
    except RuntimeError as error:  # such as a ROS_DOMAIN_ID that is none
        raise BaxterDynamicsError(f'ROS does not start: {error}') from None
    try:
        yield listener
    finally:
        rclpy.try_shutdown()

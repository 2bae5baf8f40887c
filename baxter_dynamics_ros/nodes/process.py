"""Process of a node: ends with a message if the node cannot start, and shuts down in order."""

from argparse import ArgumentParser
from collections.abc import Callable
from contextlib import suppress
import faulthandler
import gc
import signal
import sys
import traceback

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import NotInitializedException, ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import uninstall_signal_handlers
from rclpy.utilities import remove_ros_args

from ..model.exceptions import BaxterDynamicsError

_WAKE_PERIOD = 0.5  # maximum time until the executor notices a shutdown of the context [s]
_LOG_PERIOD = 1.0  # minimum time between log lines about failing callbacks [s]
_SHUTDOWN_LIMIT = 8.0  # time limit for Fast DDS to destroy its participant [s]


class GuardedExecutor(SingleThreadedExecutor):
    """Single-threaded executor that logs and counts exceptions in callbacks and continues."""

    def __init__(self) -> None:
        super().__init__()
        self.failures = 0  # number of exceptions since the start
        self.last_failure = ''  # type and text of the last one

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for one callback and run it; raise only after the context has been shut down."""
        try:
            super().spin_once(timeout_sec)
        except ExternalShutdownException:
            raise
        except Exception as error:
            if not self.context.ok():
                raise ExternalShutdownException from error  # used after shutdown
            self._report(error)

    def _report(self, error: Exception) -> None:
        self.failures += 1
        self.last_failure = f'{type(error).__name__}: {error}'
        for node in self.get_nodes()[:1]:
            cause = ''.join(traceback.format_exception(error)).rstrip()
            node.get_logger().error(
                f'a callback failed and was skipped ({self.failures} so far): {cause}',
                throttle_duration_sec=_LOG_PERIOD)


def run(make_node: Callable[[], Node], name: str, args: list[str] | None = None) -> int:
    """
    Run a node until SIGINT or SIGTERM.

    Parameters
    ----------
    make_node : callable
        Returns the node.
    name : str
        Prefix of error messages.
    args : list of str, optional
        Command line; ``sys.argv`` by default. Others than ROS arguments raise SystemExit.

    Returns
    -------
    int
        Exit code: 0 after a signal, 1 if the node cannot start, with one line on stderr.

    """
    code = _run(make_node, name, args)
    gc.collect()  # destroys entities held by tracebacks and reference cycles
    faulthandler.cancel_dump_traceback_later()
    return code


def _run(make_node: Callable[[], Node], name: str, args: list[str] | None) -> int:
    node, is_initialized = None, False
    try:
        _reject_arguments(make_node, name, sys.argv if args is None else args)
        rclpy.init(args=args)
        is_initialized = True
        node = make_node()
        if rclpy.ok():  # no signal has arrived meanwhile
            _spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except (BaxterDynamicsError, NotInitializedException, ParameterException,
            RuntimeError) as error:
        # RuntimeError: rcl rejects arguments or a QoS profile, or a signal during construction.
        if rclpy.ok() or not is_initialized:
            print(f'{name}: {error}', file=sys.stderr)
            return 1
    finally:
        _shut_down(node)
    return 0


def _spin(node: Node) -> None:
    """
    Run callbacks until the context ends.

    On a signal, a thread of rclpy first wakes the executor and then shuts down the context. A fast
    executor still finds the context valid and waits again, forever if no message arrives. The
    timer ends that wait.
    """
    executor = GuardedExecutor()
    node.create_timer(_WAKE_PERIOD, lambda: None, clock=Clock(clock_type=ClockType.STEADY_TIME))
    executor.add_node(node)
    try:
        executor.spin()
    finally:
        _ignore_signals()  # ends the thread of rclpy that uses the executor's guard condition
        executor.shutdown()


def _shut_down(node: Node | None) -> None:
    """
    Destroy the node, then shut down the context, in this order.

    Fast DDS may deadlock when it destroys a participant while another process leaves: the
    destruction holds a mutex and waits for a discovery callback, which waits for the mutex. The
    process then exits with code 1 and prints the stack on stderr.
    """
    faulthandler.dump_traceback_later(_SHUTDOWN_LIMIT, exit=True, file=2)
    _ignore_signals()
    with suppress(RuntimeError):  # some entities need a valid context
        if node is not None:
            node.destroy_node()
    with suppress(RuntimeError):  # already shut down by a signal
        rclpy.get_default_context().try_shutdown()


def _ignore_signals() -> None:
    """Keep a second signal, as ros2 launch may send, from interrupting the shutdown."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    uninstall_signal_handlers()  # may restore the earlier handlers
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)


def _reject_arguments(make_node: Callable[[], Node], name: str, args: list[str]) -> None:
    parser = ArgumentParser(prog=name, description=make_node.__doc__, epilog=(
        'Settings are ROS parameters: --ros-args -p name:=value, or --params-file FILE.'))
    _, rest = parser.parse_known_args(remove_ros_args(args)[1:])
    if rest:
        given = ' '.join(args[1:])  # without -p, rcl treats name:=value as a remap rule
        parser.error(f'unrecognized arguments: {" ".join(rest)}' + (':=' in given) * (
            f'; ROS arguments follow --ros-args: {name} --ros-args {given}'))

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

from ..model import BaxterDynamicsError

_WAKE_PERIOD = 0.5  # maximum time until the executor notices a shutdown of the context [s]
_LOG_PERIOD = 1.0  # minimum time between log lines about failing callbacks [s]
_SHUTDOWN_LIMIT = 8.0  # time limit for Fast DDS to destroy its participant [s]


class GuardedExecutor(SingleThreadedExecutor):
    """Single-threaded executor that logs and counts exceptions in callbacks and continues."""

    def __init__(self) -> None:
        super().__init__()
        self.failures = 0  # number of exceptions since the start
        self.last_failure = ''  # type and text of the last one

    def spin(self) -> None:
        """Run callbacks until the context is shut down."""
        while self.context.ok():
            try:
                self.spin_once()
            except Exception as error:
                if self.context.ok():  # otherwise something was used after the shutdown
                    self._report(error)

    def _report(self, error: Exception) -> None:
        self.failures += 1
        self.last_failure = f'{type(error).__name__}: {error}'
        cause = ''.join(traceback.format_exception(error)).rstrip()
        for node in self.get_nodes():
            node.get_logger().error(
                f'a callback failed and was skipped ({self.failures} so far): {cause}',
                throttle_duration_sec=_LOG_PERIOD)


def run(make_node: Callable[[], Node], name: str, args: list[str] | None = None) -> int:
    """
    Run a node until SIGINT, SIGTERM or SIGHUP; return the exit code.

    That is 0 after a signal, and 1 after one line on stderr if the node cannot start. Arguments
    (``sys.argv`` by default) other than ROS arguments raise SystemExit.
    """
    if signal.getsignal(signal.SIGHUP) is signal.SIG_DFL:  # the terminal was closed, without nohup
        signal.signal(signal.SIGHUP, lambda *given: signal.raise_signal(signal.SIGTERM))
    code = _run(make_node, name, sys.argv if args is None else args)
    gc.collect()  # destroys entities held by tracebacks and reference cycles
    faulthandler.cancel_dump_traceback_later()
    return code


def _run(make_node: Callable[[], Node], name: str, args: list[str]) -> int:
    node = executor = None
    is_initialized = False
    try:
        _reject_arguments(make_node, name, args)
        rclpy.init(args=args)
        is_initialized = True
        node = make_node()
        if rclpy.ok():  # no signal has arrived meanwhile
            executor = GuardedExecutor()
            # On a signal, a thread of rclpy first wakes the executor and then shuts down the
            # context. A fast executor still finds the context valid and waits again, forever if no
            # message arrives. The timer ends that wait.
            node.create_timer(
                _WAKE_PERIOD, lambda: None, clock=Clock(clock_type=ClockType.STEADY_TIME))
            executor.add_node(node)
            executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except (BaxterDynamicsError, NotInitializedException, ParameterException,
            RuntimeError) as error:
        # RuntimeError: rcl rejects arguments or a QoS profile, or a signal during construction.
        if rclpy.ok() or not is_initialized:
            print(f'{name}: {error}', file=sys.stderr)
            return 1
    finally:
        _shut_down(node, executor)
    return 0


def _shut_down(node: Node | None, executor: GuardedExecutor | None) -> None:
    """
    End executor, node and context, in this order.

    Fast DDS may deadlock when it destroys a participant while another process leaves: the
    destruction holds a mutex and waits for a discovery callback, which waits for the mutex. The
    process then exits with code 1 and prints the stack on stderr.
    """
    faulthandler.dump_traceback_later(_SHUTDOWN_LIMIT, exit=True, file=2)
    # rclpy's thread for signals uses the executor's guard condition, so it ends first. A second
    # signal, as ros2 launch may send, must not interrupt the shutdown: uninstalling may restore
    # the earlier handlers.
    _ignore_signals()
    uninstall_signal_handlers()
    _ignore_signals()
    if executor is not None:
        executor.shutdown()
    with suppress(RuntimeError):  # some entities need a valid context
        if node is not None:
            node.destroy_node()
    with suppress(RuntimeError):  # already shut down by a signal
        rclpy.get_default_context().try_shutdown()


def _ignore_signals() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)


def _reject_arguments(make_node: Callable[[], Node], name: str, args: list[str]) -> None:
    usage = 'ROS parameters: --ros-args -p NAME:=VALUE, or --ros-args --params-file FILE.'
    parser = ArgumentParser(prog=name, description=make_node.__doc__, epilog=usage)
    # Before --ros-args, rcl would take name:=value as a remap rule.
    begin = args.index('--ros-args') if '--ros-args' in args else len(args)
    try:
        rest = args[1:begin] + remove_ros_args(['', *args[begin:]])[1:]
    except RuntimeError as error:  # such as a list of ROS arguments without a flag
        raise BaxterDynamicsError(f'unusable arguments: {error}. {usage}') from None
    if rest := parser.parse_known_args(rest)[1]:
        parser.error(f'unrecognized arguments: {" ".join(rest)}. {usage}')

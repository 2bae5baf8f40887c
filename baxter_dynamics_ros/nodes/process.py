"""A node as a process: spin until a signal, survive failing callbacks, end in order."""

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

_WAKE_PERIOD = 0.5  # [s], the longest wait for the executor to notice that the context ended
_LOG_PERIOD = 1.0  # [s] between two log lines about failing callbacks
_END_WITHIN = 8.0  # [s] for Fast DDS to destroy its participant


class GuardedExecutor(SingleThreadedExecutor):
    """
    Single-threaded executor that logs and counts exceptions of callbacks, and goes on.

    Attributes
    ----------
    failures : int
        Number of exceptions since the start.
    last_failure : str
        Type and text of the last one; empty if there was none.

    """

    def __init__(self) -> None:
        super().__init__()
        self.failures = 0
        self.last_failure = ''

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for one callback and run it; raise only when the context has ended."""
        try:
            super().spin_once(timeout_sec)
        except ExternalShutdownException:
            raise
        except Exception as error:
            if not self.context.ok():
                raise ExternalShutdownException from error  # a callback used the ended context
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
        Command line; ``sys.argv`` by default.

    Returns
    -------
    int
        Exit code: 0 after a signal, 1 if the node cannot start, with one line on stderr.

    Raises
    ------
    SystemExit
        For ``--help``, and for arguments that are not ROS arguments.

    """
    code = _run(make_node, name, args)
    gc.collect()  # destroys what tracebacks and cycles still held
    faulthandler.cancel_dump_traceback_later()
    return code


def _run(make_node: Callable[[], Node], name: str, args: list[str] | None) -> int:
    try:
        _refuse_arguments(make_node, name, sys.argv if args is None else args)
        rclpy.init(args=args)
    except (NotInitializedException, RuntimeError) as error:  # arguments or files rcl refuses
        return _refused(name, error)
    except KeyboardInterrupt:
        return 0
    node = None
    try:
        node = make_node()
        if rclpy.ok():  # a signal may have come meanwhile
            _spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except (BaxterDynamicsError, NotInitializedException, ParameterException,
            RuntimeError) as error:
        # RuntimeError: a quality of service that rcl refuses, or a signal in mid-construction.
        if rclpy.ok():
            return _refused(name, error)
    finally:
        _end(node)
    return 0


def _spin(node: Node) -> None:
    """
    Run callbacks until the context ends.

    On a signal, a thread of rclpy first wakes the executor and then ends the context. An executor
    that is quick enough finds the context valid and waits again, for good if no message arrives.
    The timer ends that wait.
    """
    executor = GuardedExecutor()
    node.create_timer(_WAKE_PERIOD, _nothing, clock=Clock(clock_type=ClockType.STEADY_TIME))
    executor.add_node(node)
    try:
        executor.spin()
    finally:
        # A second signal, as ros2 launch may send, must not interrupt the end. The thread of
        # rclpy that uses the executor's guard condition ends before the executor does; rclpy may
        # restore the handlers of before.
        _ignore_signals()
        uninstall_signal_handlers()
        _ignore_signals()
        executor.shutdown()


def _end(node: Node | None) -> None:
    """
    Destroy the node, then end the context, and not in any order as the interpreter exits.

    Fast DDS may lock up when it destroys a participant while another process leaves: a discovery
    callback waits for the mutex that the destruction holds, which waits for the callback. Nothing
    is left to be done then, so the process exits, with 1 and the stack on stderr.
    """
    faulthandler.dump_traceback_later(_END_WITHIN, exit=True, file=2)
    if node is not None:
        with suppress(RuntimeError):  # entities that need a valid context
            node.destroy_node()
    with suppress(RuntimeError):  # a signal ended it just now
        rclpy.get_default_context().try_shutdown()


def _ignore_signals() -> None:
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, signal.SIG_IGN)


def _refuse_arguments(make_node: Callable[[], Node], name: str, args: list[str]) -> None:
    parser = ArgumentParser(prog=name, description=make_node.__doc__, epilog=(
        'Settings are ROS parameters: --ros-args -p name:=value, or --params-file FILE.'))
    _, rest = parser.parse_known_args(remove_ros_args(args)[1:])
    if rest:
        given = ' '.join(args[1:])  # rcl takes name:=value for a remap rule
        parser.error(f'unrecognized arguments: {" ".join(rest)}' + (':=' in given) * (
            f'; ROS arguments follow --ros-args: {name} --ros-args {given}'))


def _refused(name: str, error: Exception) -> int:
    print(f'{name}: {error}', file=sys.stderr)
    return 1


def _nothing() -> None:
    pass

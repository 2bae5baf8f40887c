"""A node as a process: spin, shut down cleanly, and say in one line why it cannot start."""

from argparse import ArgumentParser
from collections.abc import Callable
from contextlib import suppress
import signal
import sys

import rclpy
from rclpy.exceptions import NotInitializedException, ParameterException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.utilities import remove_ros_args

from ..model.exceptions import BaxterDynamicsError


def run(make_node: Callable[[], Node], name: str, args: list[str] | None = None) -> int:
    """
    Run a node until SIGINT or SIGTERM.

    Parameters
    ----------
    make_node : callable
        Returns the node.
    name : str
        In front of an error.
    args : list of str, optional
        Command line; ``sys.argv`` by default.

    Returns
    -------
    int
        Exit code: 0 after a signal, 1 where the node cannot start, with one line on stderr.

    Raises
    ------
    SystemExit
        For ``--help``, and for arguments that are not for ROS.

    """
    parser = ArgumentParser(prog=name, description=make_node.__doc__, epilog=(
        'Settings are ROS parameters: --ros-args -p name:=value, or --params-file FILE.'))
    started = False
    try:
        parser.parse_args(remove_ros_args(sys.argv if args is None else args)[1:])
        rclpy.init(args=args)
        started = True
        node = make_node()
    except (BaxterDynamicsError, NotInitializedException, ParameterException,
            RuntimeError) as error:
        if started and not rclpy.ok():
            return 0  # a signal ended the context while the node was being made
        # RuntimeError: a parameter file, argument or quality of service that rcl refuses.
        print(f'{name}: {error}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 0
    try:
        if rclpy.ok():  # a signal may have come meanwhile
            rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:
        if rclpy.ok():
            raise
        # A signal ended the context while a callback was still using it.
    finally:
        # A second SIGINT, as ros2 launch may send, must not kill what is ending. rclpy puts back
        # what was there before it.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        with suppress(RuntimeError):  # a signal ended it since try_shutdown() looked
            rclpy.try_shutdown()
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    return 0

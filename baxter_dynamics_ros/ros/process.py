"""A node as a process: spin, shut down cleanly, and say in one line why it cannot start."""

import sys

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException

from ..core.exceptions import BaxterDynamicsError


def run(make_node, name: str, args=None) -> int:
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

    """
    try:
        rclpy.init(args=args)
    except RuntimeError as error:  # a parameter file or argument that rcl cannot read
        print(f'{name}: {error}', file=sys.stderr)
        return 1
    try:
        rclpy.spin(make_node())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except (BaxterDynamicsError, ParameterException) as error:
        print(f'{name}: {error}', file=sys.stderr)
        return 1
    finally:
        rclpy.try_shutdown()
    return 0

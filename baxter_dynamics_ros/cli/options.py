"""Command-line options shared by several verbs."""

import argparse
from collections.abc import Callable
from typing import Any

from ..model.joints import SIDES


def number(low: float, high: float, unit: str = '',
           parse: Callable[[str], Any] = float) -> Callable[[str], Any]:
    """Return an argparse type for a number from low to high, in a unit."""
    def check(text: str) -> Any:
        try:
            value = parse(text)
        except ValueError:
            value = float('nan')
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f'expected {low} to {high}{unit and " "}{unit}, '
                                             f'got {text}')
        return value
    return check


def add_arm(parser: argparse.ArgumentParser, text: str = 'arm (default: %(default)s)',
            default: 'str | None' = 'right') -> None:
    """Add ``--arm``."""
    parser.add_argument('--arm', choices=SIDES, default=default, help=text)


def add_seed(parser: argparse.ArgumentParser, prefix: str = '') -> None:
    """Add ``--seed``."""
    parser.add_argument('--seed', type=number(0, 2 ** 31 - 1, parse=int), default=0, metavar='N',
                        help=prefix + 'seed of the sensor noise (default: %(default)s)')


def add_recordings(parser: argparse.ArgumentParser, nargs: str = '+') -> None:
    """Add the recordings and the options for reading them."""
    parser.add_argument('bags', nargs=nargs, metavar='BAG',
                        help='a rosbag2 (MCAP or SQLite), a ROS 1 bag, an .npz or a .csv file')
    add_arm(parser, 'arm (default: the only one in the recording)', None)
    parser.add_argument('--topic', metavar='NAME',
                        help='topic of the joint states (default: /robot/joint_states)')
    add_parameters(parser, 'such as the result of a calibration')


def add_parameters(parser: argparse.ArgumentParser, text: str) -> None:
    """Add ``--params`` and ``--node``."""
    parser.add_argument('--params', metavar='FILE', action='append', default=[],
                        help=f'parameter file of torque_predictor, {text}; given several times, '
                        'later files override earlier ones')
    parser.add_argument('--node', metavar='NAME', default='/torque_predictor',
                        help='node to read the parameters of (default: %(default)s)')


def add_force(parser: argparse.ArgumentParser) -> None:
    """Add ``--force``."""
    parser.add_argument('--force', action='store_true', help='replace existing output')

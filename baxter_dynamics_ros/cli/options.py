"""Command-line options shared by several verbs, and the input that they name."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any, TYPE_CHECKING

from .terminal import say
from ..estimation.settings import PredictorSettings
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import SIDES

if TYPE_CHECKING:
    from ..recordings.reader import Recordings


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
            default: str | None = 'right') -> None:
    """Add ``--arm``."""
    parser.add_argument('--arm', choices=SIDES, default=default, help=text)


def add_seed(parser: argparse.ArgumentParser, prefix: str = '') -> None:
    """Add ``--seed``."""
    parser.add_argument('--seed', type=number(0, 2 ** 31 - 1, parse=int), default=0, metavar='N',
                        help=prefix + 'seed of the sensor noise (default: %(default)s)')


def add_predictor(parser: argparse.ArgumentParser) -> None:
    """Add ``--node``, ``--topic`` and ``--arm`` of a running predictor."""
    parser.add_argument('--node', default='/torque_predictor', metavar='NAME',
                        help='name of the predictor with its namespace (default: %(default)s)')
    add_arm(parser, 'show this arm only', None)
    add_topic(parser)


def add_topic(parser: argparse.ArgumentParser) -> None:
    """Add ``--topic`` of live joint states."""
    parser.add_argument('--topic', default='/robot/joint_states', metavar='NAME',
                        help='topic of the joint states (default: %(default)s)')


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


def read_inputs(args: argparse.Namespace) -> 'tuple[PredictorSettings, Recordings]':
    """Return the settings and the recordings named by the options of add_recordings."""
    from ..recordings.reader import open_recordings
    values = read_settings(args)
    if args.arm and values.get('arm', args.arm) != args.arm:
        say(f"warning: the parameters are of the {values['arm']} arm; friction, bias and tilt "
            'differ between arms')
    recordings = open_recordings([Path(bag).expanduser() for bag in args.bags], args.topic,
                                 args.arm or values.get('arm'))
    if not recordings:
        raise BaxterDynamicsError(f'{", ".join(map(str, args.bags))}: no recordings')
    return PredictorSettings.from_parameters(values), recordings


def read_settings(args: argparse.Namespace) -> dict[str, Any]:
    """Return the parameters in the files named by the options of add_parameters."""
    if not args.params:
        return {}
    from ..recordings.parameter_file import read_parameters
    return read_parameters([Path(path).expanduser() for path in args.params], args.node,
                           lambda line: say(f'warning: {line}'))

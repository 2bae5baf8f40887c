"""Command-line options shared by several verbs, and the inputs and outputs that they name."""

import argparse
from collections.abc import Callable, Iterable
from contextlib import suppress
import os
from pathlib import Path
import tempfile
from typing import Any, TYPE_CHECKING

from .terminal import say
from ..estimation.settings import PredictorSettings
from ..model import BaxterDynamicsError, SIDES

if TYPE_CHECKING:
    from ..recordings.recording import Recording


def number(low: float, high: float, unit: str = '',
           parse: Callable[[str], Any] = float) -> Callable[[str], Any]:
    """Return an argparse type for a number from low to high, in a unit."""
    def check(text: str) -> Any:
        with suppress(ValueError):
            if low <= (value := parse(text)) <= high:
                return value
        raise argparse.ArgumentTypeError(
            f'expected {low} to {high}{unit and " "}{unit}, got {text}')
    return check


NODE = '/torque_predictor'
# Declarations of options that several verbs have.
_SHARED: dict[str, dict[str, Any]] = {
    '--arm': {'choices': SIDES, 'default': 'right', 'help': 'arm (default: %(default)s)'},
    '--seed': {'type': number(0, 2 ** 31 - 1, parse=int), 'default': 0, 'metavar': 'N',
               'help': 'seed of the sensor noise (default: %(default)s)'},
    '--topic': {'default': '/robot/joint_states', 'metavar': 'NAME',
                'help': 'topic of the joint states (default: %(default)s)'},
    '--node': {'default': NODE, 'metavar': 'NAME',
               'help': 'name of the predictor with its namespace (default: %(default)s)'},
}


def add(parser: argparse.ArgumentParser, option: str, **changes: Any) -> None:
    """Add an option that several verbs have, with changes of its declaration."""
    parser.add_argument(option, **{**_SHARED[option], **changes})


def add_predictor(parser: argparse.ArgumentParser) -> None:
    """Add ``--node``, ``--topic`` and ``--arm`` of a running predictor."""
    add(parser, '--node')
    add(parser, '--arm', default=None, help='show this arm only')
    add(parser, '--topic')


def add_parameters(parser: argparse.ArgumentParser, text: str) -> None:
    """Add ``--params`` and ``--node``; see :func:`read_settings`."""
    parser.add_argument('--params', metavar='FILE', action='append', default=[],
                        help=f'parameter file of torque_predictor, {text}; may be repeated, and '
                        'later files override earlier ones')
    add(parser, '--node', help='node in FILE to read the parameters of (default: %(default)s)')


def add_recordings(parser: argparse.ArgumentParser, nargs: str = '+') -> None:
    """Add the recordings, the options for reading them, and ``--force``; see read_inputs."""
    parser.add_argument('bags', nargs=nargs, metavar='BAG',
                        help='a rosbag2 (MCAP or SQLite), a ROS 1 bag, an .npz or a .csv file')
    add(parser, '--arm', default=None, help='arm (default: the only one in the recording)')
    add(parser, '--topic', default=None,
        help='topic of the joint states (default: /robot/joint_states, or the only one)')
    add_parameters(parser, 'such as the result of a calibration')
    parser.add_argument('--force', action='store_true', help='replace existing output')


def read_settings(args: argparse.Namespace) -> dict[str, Any]:
    """Return the parameters in the files named by the options of add_parameters."""
    if not args.params:
        return {}
    from ..recordings.parameter_file import read_parameters
    return read_parameters([Path(os.path.expanduser(path)) for path in args.params], args.node,
                           lambda line: say(f'warning: {line}'))


def read_inputs(args: argparse.Namespace) -> 'tuple[PredictorSettings, list[Recording]]':
    """Return the settings and the recordings named by the options of add_recordings."""
    from ..recordings.bags import open_recordings
    values = read_settings(args)
    settings = PredictorSettings.from_parameters(values)
    if args.arm and values.get('arm', args.arm) != args.arm:
        say(f"warning: the parameters are of the {values['arm']} arm; friction, bias and tilt "
            'differ between arms')
    recordings = open_recordings([Path(os.path.expanduser(bag)) for bag in args.bags], args.topic,
                                 args.arm or values.get('arm'), settings.joint_prefix)
    if not recordings:
        raise BaxterDynamicsError(f'{", ".join(map(str, args.bags))}: no recordings')
    return settings, recordings


def output_path(option: str, output: str | Path, endings: tuple[str, ...] = (),
                force: bool | None = True, inputs: Iterable[str] = ()) -> Path:
    """
    Return the absolute path of an output: a file with one of the endings, or a folder.

    Raises BaxterDynamicsError if it cannot be written, belongs to an input, or exists and may not
    be replaced; None as ``force`` means that the command has no such option.
    """
    path = resolved(output)
    try:
        tempfile.TemporaryFile(dir=_existing_folder(option, path, endings)).close()
        exists = path.is_file() or path.is_dir() and any(path.iterdir())
    except OSError as error:
        raise BaxterDynamicsError(
            f'{option}: {path} cannot be written ({error.strerror})') from None
    for name in inputs if exists else ():
        source = resolved(name)
        if os.path.exists(source) and (path.is_relative_to(source) or path.samefile(source)):
            raise BaxterDynamicsError(f'{option}: {path} belongs to the input {name}')
    if exists and not force:
        raise BaxterDynamicsError(f'{option}: {path} exists; choose another name'
                                  + ('' if force is None else ', or replace it with --force'))
    return path


def resolved(name: str | Path) -> Path:
    """Return the absolute path without symbolic links; ~ is the home folder."""
    try:
        return Path(os.path.realpath(os.path.expanduser(name)))
    except FileNotFoundError:
        raise BaxterDynamicsError(
            'the current folder no longer exists: cd to another one') from None


def _existing_folder(option: str, path: Path, endings: tuple[str, ...]) -> Path:
    """Return the folder that holds a file with one of the endings, or will hold a new folder."""
    if endings and path.suffix.lower() not in endings:
        raise BaxterDynamicsError(
            f'{option}: expected a name ending in {" or ".join(endings)}, got {path.name}')
    folder = path.parent if endings else next(
        place for place in (path, *path.parents) if os.path.lexists(place))
    if not folder.is_dir():
        raise BaxterDynamicsError(f'{option}: ' + (
            f'{folder} is not a folder' if folder.exists() else f'no folder {folder}'))
    if endings and path.is_dir():
        raise BaxterDynamicsError(f'{option}: {path} is a folder')
    return folder

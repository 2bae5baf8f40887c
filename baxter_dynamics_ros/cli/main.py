"""The baxter_dynamics command and its verbs, and the commands of the nodes."""

import argparse
import ast
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib import import_module
import os
from pathlib import Path
import shlex
import signal
import sys
from typing import NoReturn

from .terminal import complain
from .. import __version__
from ..model import BaxterDynamicsError, printable

# Verb -> the extra of setup.py that it needs. A verb is a module of this folder with its
# description as docstring, add_arguments(parser) and main(args). It imports what the extra
# installs in main, so that --help works without.
VERBS = {'demo': 'demo', 'watch': 'demo', 'panel': 'panel', 'doctor': 'ros', 'experiment': 'demo',
         'evaluate': 'offline', 'calibrate': 'offline', 'export': 'export'}


class _Parser(argparse.ArgumentParser):
    """Argument parser that escapes unprintable characters in its errors."""

    def error(self, message: str) -> NoReturn:
        """Print usage and error, and exit with code 2."""
        super().error(printable(message))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a verb; return the exit code: 0, or 1 with the reason on stderr."""
    os.environ['MPLBACKEND'] = 'agg'  # the backend of a notebook may not be installed
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_DFL:  # otherwise as with nohup
            signal.signal(number, lambda number, frame: sys.exit(128 + number))  # clean up
    command = 'baxter_dynamics'
    try:
        args = parse(sys.argv[1:] if arguments is None else arguments)
        command += f' {args.verb}'
        with needs(VERBS[args.verb]):
            code: int = args.main(args)
            return code
    except BaxterDynamicsError as error:
        complain(f'{command}: {error}')
        return 1
    except KeyboardInterrupt:
        return 130


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the arguments of a verb, with ``verb``, its ``main`` and the whole command line."""
    parser = _Parser(
        prog='baxter_dynamics', description="Lagrange-Euler dynamics of the Baxter robot's arms.")
    parser.add_argument('--version', action='version', version=__version__)
    verbs = parser.add_subparsers(dest='verb', metavar='COMMAND', required=True)
    for name in VERBS:
        source = Path(__file__).with_name(f'{name}.py').read_text('utf-8')
        description = ast.get_docstring(ast.parse(source)) or ''
        subparser = verbs.add_parser(
            name, help=description.partition('.')[0], description=description)
        if name in arguments:  # the others take time to import
            verb = import_module(f'{__package__}.{name}')
            verb.add_arguments(subparser)
            subparser.set_defaults(main=verb.main)
    return parser.parse_args(arguments, argparse.Namespace(
        command_line=shlex.join(['baxter_dynamics', *arguments])))


@contextmanager
def needs(extra: str) -> Iterator[None]:
    """Raise BaxterDynamicsError for a missing library; it names the extra that installs it."""
    try:
        yield
    except ImportError as error:
        raise BaxterDynamicsError(
            f'{error}. Without ROS, install the {extra} extra: pip install ".[{extra}]"; on a '
            'ROS machine, install the missing library with rosdep or pip') from None


def _run_node(executable: str) -> int:
    try:
        with needs('ros'):
            return int(import_module(f'baxter_dynamics_ros.nodes.{executable}').main())
    except BaxterDynamicsError as error:
        complain(f'{executable}: {error}')
        return 1
    except KeyboardInterrupt:  # while modules load, before the node handles signals
        return 0


torque_predictor = partial(_run_node, 'torque_predictor')
fake_baxter = partial(_run_node, 'fake_baxter')
joint_state_bridge = partial(_run_node, 'joint_state_bridge')

if __name__ == '__main__':
    sys.exit(main())

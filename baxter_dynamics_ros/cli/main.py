"""baxter_dynamics: the command and its subcommands."""

import argparse
import sys

from .. import __version__
from ..core.exceptions import BaxterDynamicsError


def main(arguments=None) -> int:
    """
    Run a subcommand.

    Returns
    -------
    int
        Exit code: 0, or 1 with the reason on stderr.

    """
    parser = argparse.ArgumentParser(
        prog='baxter_dynamics',
        description="Lagrange-Euler dynamics of the Baxter robot's arms, beside ROS 2.")
    parser.add_argument('--version', action='version', version=__version__)
    commands = parser.add_subparsers(dest='command', required=True)
    demo = commands.add_parser(
        'demo', help='run the predictor on a fake Baxter, and show what it finds',
        description='Start a fake Baxter and the predictor as processes of their own, compare '
        'what is predicted with what is measured, call both services, and save a picture.')
    demo.add_argument('--duration', type=_duration, default=20.0, metavar='SECONDS',
                      help='how long to look (default: %(default)s)')
    demo.add_argument('--output', default='baxter_dynamics_demo.png', metavar='FILE',
                      help='the picture; its ending says which kind (default: %(default)s)')
    demo.add_argument('--arm', choices=('right', 'left'), default='right')
    options = parser.parse_args(arguments)
    try:
        return _demo(options)
    except BaxterDynamicsError as error:
        print(f'baxter_dynamics {options.command}: {error}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


def _demo(options) -> int:
    try:
        from .demo import run
    except ImportError as error:
        raise BaxterDynamicsError(
            f'{error}. Without ROS, install the demo extra: pip install ".[demo]"; on a ROS '
            'machine: pip install mujoco hpp-baxter, and rosdep for the rest') from None
    return run(options.arm, options.duration, options.output)


def _duration(text: str) -> float:
    value = float(text)
    if not 2.0 <= value <= 3600.0:
        raise argparse.ArgumentTypeError(f'expected 2 to 3600 seconds, got {text}')
    return value


if __name__ == '__main__':
    sys.exit(main())

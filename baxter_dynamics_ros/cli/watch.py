"""
Show a running torque_predictor live in the terminal.

Shows measured and predicted effort, residual, external effort, contact, rates and diagnostics.
Prints one line per second where the output is not a terminal. q or Ctrl-C quits, ? explains the
columns.
"""

import argparse

from .options import add_predictor, number, output_path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics watch``."""
    add_predictor(parser)
    parser.add_argument('--rate', type=number(0.2, 30, 'Hz'), default=5.0, metavar='HZ',
                        help='screen updates per second (default: %(default)g)')
    parser.add_argument('--duration', type=number(0.5, 86400, 'seconds'), metavar='SECONDS',
                        help='stop after this time (default: run until Ctrl-C); with --once, the '
                        'longest time to wait (default: 10)')
    parser.add_argument('--once', action='store_true',
                        help='wait for data, print it once and exit; exit code 1 if none arrives')
    parser.add_argument('--save', metavar='FILE.svg', help='save the last view as an SVG figure')


def main(args: argparse.Namespace) -> int:
    """Show a predictor live, as lines or once."""
    from .listener import Listener
    from .monitor import Monitor
    from .watch_view import save, watch
    figure = output_path('--save', args.save, ('.svg',)) if args.save else None
    with Listener('watch') as listener:
        monitor = Monitor(listener, args.node, args.topic, args.arm)
        try:
            watch(monitor, args)
        finally:  # also after Ctrl-C
            if figure is not None:
                save(monitor, figure)
    return 0

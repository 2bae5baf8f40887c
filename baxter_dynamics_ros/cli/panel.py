"""
Show a running torque_predictor in 3D in the web browser.

The page shows the robot with the external force, measured and predicted effort, the residual and
its expected range over the last 30 s, contact and diagnostics. It has buttons for the services of
the predictor. Ctrl-C quits.
"""

import argparse

from .options import add_predictor, number


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``baxter_dynamics panel``."""
    add_predictor(parser)
    parser.add_argument('--host', default='localhost', metavar='ADDRESS',
                        help='address to listen on (default: %(default)s, this machine only; '
                        '0.0.0.0: all networks, where anybody may press the buttons)')
    parser.add_argument('--port', type=number(1, 65535, parse=int), default=8080, metavar='N',
                        help='port, or the first free one after it (default: %(default)s)')


def main(args: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C."""
    from .listener import Listener
    with Listener('panel') as listener:
        from .panel_page import serve  # its libraries would drop the exception of Ctrl-C
        serve(listener, args)
    return 0

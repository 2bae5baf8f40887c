"""
Push the fake Baxter's hand for a while, by setting its parameter force.

Equivalent to `ros2 param set /fake_baxter force "[0.0, 0.0, -25.0]"`, without the ros2 command.
The force is set back to zero at the end and on Ctrl-C.

Run: python examples/push.py
"""

from argparse import ArgumentParser
from collections.abc import Sequence
from contextlib import suppress
import signal
from time import sleep

import rclpy
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.signals import SignalHandlerOptions


def main() -> None:
    """Wait, push and release."""
    parser = ArgumentParser()
    parser.add_argument('--after', type=float, default=0.0, help='delay before the push [s]')
    parser.add_argument('--duration', type=float, default=2.0, help='duration of the push [s]')
    parser.add_argument('--force', type=float, nargs=3, default=(0.0, 0.0, -25.0),
                        help="in the axes of the robot's base, up to 200 each [N]")
    options = parser.parse_args()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)  # to release the arm on Ctrl-C
    # A script's background processes start with SIGINT ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    node = rclpy.create_node('push')
    client = AsyncParameterClient(node, 'fake_baxter')
    if not client.wait_for_services(10.0):
        parser.exit(1, 'fake_baxter is not running\n')

    def push(force: Sequence[float]) -> None:
        answer = client.set_parameters([Parameter('force', value=list(force))])
        rclpy.spin_until_future_complete(node, answer, timeout_sec=5.0)
        if not answer.done():
            parser.exit(1, 'fake_baxter does not respond\n')
        if not answer.result().results[0].successful:
            parser.exit(1, answer.result().results[0].reason + '\n')
        print(f'pushed with {force} N' if any(force) else 'let go', flush=True)

    with suppress(KeyboardInterrupt):
        sleep(options.after)
        push(options.force)
        sleep(options.duration)
    push((0.0, 0.0, 0.0))


if __name__ == '__main__':
    with suppress(KeyboardInterrupt):
        main()

"""Figure of the watch command, while a hand pushes the fake Baxter."""

from __future__ import annotations

import os
from pathlib import Path
import subprocess
import sys

from baxter_dynamics_ros.cli.processes import NodeProcess
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.parameter import Parameter

WIDTH = 80  # columns
FREE, PUSHED = 10, 2.2  # [s]: in free motion, and then pushed, until the picture is taken
FORCE = [0.0, 4.0, -18.0]  # [N] on the hand, axes of the robot's base
DOMAIN = 1 + os.getpid() % 100  # nobody else's


def draw(path: Path) -> None:
    """Run a fake Baxter and the predictor, push the arm, and save what watch shows."""
    os.environ.update(ROS_DOMAIN_ID=str(DOMAIN), ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
    rclpy.init(args=[])
    try:
        node = rclpy.create_node('hand')
        client = node.create_client(SetParameters, '/fake_baxter/set_parameters')
        with NodeProcess('fake_baxter'), NodeProcess('torque_predictor'):
            if not client.wait_for_service(timeout_sec=20.0):
                raise RuntimeError('the fake Baxter does not start')
            watch = subprocess.Popen(
                [sys.executable, '-m', 'baxter_dynamics_ros.cli.main', 'watch',
                 '--duration', str(FREE + PUSHED), '--save', str(path)],
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True,
                env={**os.environ, 'COLUMNS': str(WIDTH)})
            assert watch.stdout is not None
            for _ in range(FREE):
                watch.stdout.readline()  # one a second
            pushed = client.call_async(SetParameters.Request(
                parameters=[Parameter('force', value=FORCE).to_parameter_msg()]))
            rclpy.spin_until_future_complete(node, pushed, timeout_sec=5.0)
            said, _ = watch.communicate(timeout=60.0)
            if watch.returncode or 'CONTACT' not in said:
                raise RuntimeError(f'no picture of a contact: {said}')
    finally:
        rclpy.try_shutdown()

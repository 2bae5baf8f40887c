"""Figures of commands: the demo, a report in a browser, and watch during a push."""

from __future__ import annotations

import os
from pathlib import Path
import shutil
import subprocess
import sys
import tempfile

_WIDTH, _HEIGHT = 1200, 1420  # of the upper part of the report [px]
_BROWSERS = ('chromium', 'chromium-browser', 'google-chrome')
_COMMAND = [sys.executable, '-m', 'baxter_dynamics_ros.cli.main']
_COLUMNS = 80  # of the terminal
_FREE, _PUSHED = 10, 2.2  # in free motion, and then pushed, until the picture is taken [s]
_FORCE = [0.0, 4.0, -18.0]  # on the hand, axes of the robot's base [N]


def demo(path: Path) -> None:
    """Run the demo, which takes 20 s, and save its picture."""
    subprocess.run([*_COMMAND, 'demo', '--output', path], check=True, stdout=subprocess.DEVNULL)


def report(path: Path) -> None:
    """Run the experiment on the circle, and take a picture of its report."""
    from playwright.sync_api import sync_playwright
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if browser is None:
        raise FileNotFoundError(2, 'a picture of the report needs a browser: install Chromium')
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        subprocess.run([*_COMMAND, 'experiment', 'circle', '-o', f'{folder}/circle'], check=True,
                       stdout=subprocess.DEVNULL)
        file, = Path(folder).rglob('report.html')
        window = playwright.chromium.launch(executable_path=browser)
        page = window.new_page(viewport={'width': _WIDTH, 'height': _HEIGHT})
        page.goto(file.as_uri())
        page.screenshot(path=path)
        window.close()


def watch(path: Path) -> None:
    """Run a fake Baxter and the predictor, push the arm, and save the view of watch."""
    from baxter_dynamics_ros.cli.processes import NodeProcess
    from rcl_interfaces.srv import SetParameters
    import rclpy
    from rclpy.parameter import Parameter
    os.environ.update(ROS_DOMAIN_ID=str(1 + os.getpid() % 100), COLUMNS=str(_COLUMNS),
                      ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
    rclpy.init(args=[])
    try:
        node = rclpy.create_node('hand')
        client = node.create_client(SetParameters, '/fake_baxter/set_parameters')
        with NodeProcess('fake_baxter'), NodeProcess('torque_predictor'):
            if not client.wait_for_service(timeout_sec=20.0):
                raise RuntimeError('the fake Baxter does not start')
            process = subprocess.Popen(
                [*_COMMAND, 'watch', '--duration', str(_FREE + _PUSHED), '--save', path],
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
            assert process.stdout is not None
            for _ in range(_FREE):
                process.stdout.readline()  # one per second
            pushed = client.call_async(SetParameters.Request(
                parameters=[Parameter('force', value=_FORCE).to_parameter_msg()]))
            rclpy.spin_until_future_complete(node, pushed, timeout_sec=5.0)
            output, _ = process.communicate(timeout=60.0)
            if process.returncode or 'CONTACT' not in output:
                raise RuntimeError(f'no picture of a contact: {output}')
    finally:
        rclpy.try_shutdown()

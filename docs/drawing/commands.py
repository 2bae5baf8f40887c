"""Figures of commands: a report, and watch and panel during a push."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from typing import Any

_WIDTH, _HEIGHT = 1200, 1420  # of the upper part of the report [px]
_BROWSERS = ('chromium', 'chromium-browser', 'google-chrome')
_COMMAND = [sys.executable, '-m', 'baxter_dynamics_ros.cli.main']
_COLUMNS = 80  # of the terminal
_FREE, _PUSHED = 10, 2.2  # in free motion, and then pushed, until the picture is taken [s]
_FORCE = [0.0, 4.0, -18.0]  # on the hand, axes of the robot's base [N]
# The fake Baxter's friction, and what it leaves of the residual in free motion [N m].
_CALIBRATED = ('effort_model.coulomb:=[0.4, 0.7, 0.3, 0.3, 0.1, 0.1, 0.03]',
               'effort_model.deviation:=[0.15, 0.2, 0.12, 0.1, 0.03, 0.03, 0.012]')


def report(path: Path) -> None:
    """Run the experiment on the circle, and take a picture of its report."""
    with tempfile.TemporaryDirectory() as folder, _page(_WIDTH, _HEIGHT) as page:
        subprocess.run([*_COMMAND, 'experiment', 'circle', '-o', f'{folder}/circle'], check=True,
                       stdout=subprocess.DEVNULL)
        file, = Path(folder).rglob('report.html')
        page.goto(file.as_uri())
        page.screenshot(path=path)


def watch(path: Path) -> None:
    """Run a fake Baxter and the predictor, push the arm, and save the view of watch."""
    with _robot(*_CALIBRATED) as push, subprocess.Popen(
            [*_COMMAND, 'watch', '--duration', str(_FREE + _PUSHED), '--save', path],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for _ in range(_FREE):
            process.stdout.readline()  # one per second
        push()
        output, _ = process.communicate(timeout=60.0)
        if process.returncode or 'CONTACT' not in output:
            raise RuntimeError(f'no picture of a contact: {output}')


def panel(path: Path) -> None:
    """Run a calibrated predictor, push the arm, and take a picture of the panel."""
    with _robot(*_CALIBRATED) as push, _page(1280, 800) as page, subprocess.Popen(
            [*_COMMAND, 'panel', '--port', '8700'], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        page.goto(process.stdout.readline().removeprefix('panel: ').strip())
        page.get_by_text('No contact').wait_for(timeout=90_000)
        time.sleep(2 * _FREE)
        page.add_style_tag(content='.mantine-Notifications-root { display: none }')
        push()
        page.get_by_text('N at the hand').wait_for(timeout=90_000)
        page.screenshot(path=path, timeout=90_000)
        process.send_signal(signal.SIGINT)


@contextmanager
def _page(width: int, height: int) -> Iterator[Any]:
    """Open a page of a size [px] in a browser."""
    from playwright.sync_api import sync_playwright
    browser = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if browser is None:
        raise FileNotFoundError(2, 'the picture needs a browser: install Chromium')
    with sync_playwright() as playwright:
        window = playwright.chromium.launch(executable_path=browser)
        yield window.new_page(viewport={'width': width, 'height': height})
        window.close()


@contextmanager
def _robot(*parameters: str) -> Iterator[Callable[[], None]]:
    """Run a fake Baxter and the predictor; yield a function that pushes the hand."""
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

        def push() -> None:
            pushed = client.call_async(SetParameters.Request(
                parameters=[Parameter('force', value=_FORCE).to_parameter_msg()]))
            rclpy.spin_until_future_complete(node, pushed, timeout_sec=5.0)

        with NodeProcess('fake_baxter'), NodeProcess(
                'torque_predictor', ['--ros-args', *(word for parameter in parameters
                                                     for word in ('-p', parameter))]):
            if not client.wait_for_service(timeout_sec=20.0):
                raise RuntimeError('the fake Baxter does not start')
            yield push
    finally:
        rclpy.try_shutdown()

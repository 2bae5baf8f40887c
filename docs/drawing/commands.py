"""Figures of what commands show: the demo's picture, and a report in a browser."""

from __future__ import annotations

from pathlib import Path
import shutil
import subprocess
import sys
import tempfile

WIDTH, HEIGHT = 1200, 1420  # of the report's upper part [pixels]
BROWSERS = ('chromium', 'chromium-browser', 'google-chrome')


def demo(path: Path) -> None:
    """Run the demo, which takes 20 s, and save its picture."""
    _run('demo', '--output', str(path))


def report(path: Path) -> None:
    """Run the experiment on the circle, and take a picture of its report."""
    from playwright.sync_api import sync_playwright
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise FileNotFoundError(2, 'a picture of the report needs a browser: install Chromium')
    with tempfile.TemporaryDirectory() as folder:
        _run('experiment', 'circle', '-o', f'{folder}/circle')
        page_file, = Path(folder).rglob('report.html')
        with sync_playwright() as playwright:
            window = playwright.chromium.launch(executable_path=browser)
            page = window.new_page(viewport={'width': WIDTH, 'height': HEIGHT})
            page.goto(page_file.as_uri())
            page.screenshot(path=str(path))
            window.close()


def _run(*arguments: str) -> None:
    subprocess.run([sys.executable, '-m', 'baxter_dynamics_ros.cli.main', *arguments], check=True,
                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)

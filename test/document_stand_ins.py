"""What a reader has and a checkout has not: bags, recordings and a calibration of a robot."""

from io import StringIO
from pathlib import Path
import shutil

from baxter_dynamics_ros.model.joints import JOINTS
import numpy as np

BAGS = ('my_bag', 'another_bag', 'a_third_bag')
CALIBRATION = 'my_robot.yaml'
OUTPUTS = ('-o', '--output', '--save-bag')  # the next word is made by the command
DURATION = 12.0  # [s] of a bag: a calibration wants ten


class StandIns:
    """
    Stand-ins, and what commands have made of them: each is made once, and copied to the pages.

    Parameters
    ----------
    folder : Path
        Where they are made.

    """

    def __init__(self, folder: Path):
        self.folder = folder
        self.seen = set()  # command lines of nodes that have been seen to start
        self._made = {}
        self._robot = None

    def provide(self, words: list, folder: Path):
        """Put what a command reads, and nothing has made so far, into a page's folder."""
        for before, word in zip(['', *words], words):
            name = word.split('=')[-1]
            path = folder / name
            if before in OUTPUTS or path.exists() or '/' in name:
                continue
            if name in BAGS:
                shutil.copytree(self._bag(name), path)
            elif name == CALIBRATION:
                shutil.copy2(self._calibration(), path)
            elif name.endswith('.npz'):
                self._arrays(path)

    def once(self, words: list, folder: Path, run) -> str:
        """
        Run a command whose like has not been run yet; give the page what it makes.

        Alike are commands that differ in nothing but which bag, or which file, they read.
        """
        key = tuple(_kind(folder / word, word) for word in words)
        if key not in self._made:
            before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
            output = run()
            store = self.folder / str(len(self._made))
            store.mkdir()
            for path in folder.iterdir():
                if before.get(path) != path.stat().st_mtime_ns:
                    _copy(path, store / path.name)
            self._made[key] = output, store
            return output
        output, store = self._made[key]
        for path in store.iterdir():
            _copy(path, folder / path.name)
        return output

    def plan(self, folder: Path):
        """Put what calibrate --plan makes, but shorter, into a folder."""
        from baxter_dynamics_ros.simulation.plan_file import write_plan
        shutil.copytree(self._bag(BAGS[0]), folder / 'bag')
        write_plan(folder / 'plan.csv', 'right')

    def _bag(self, name):
        from baxter_dynamics_ros.cli.experiment import record_bag
        from baxter_dynamics_ros.simulation.robot import FakeBaxter
        from rich.console import Console
        path = self.folder / name
        if not path.exists():
            self._robot = self._robot or FakeBaxter('right', 'exciting')
            record_bag(path, self._robot, DURATION, 100.0, 0, Console(file=StringIO()))
        return path

    def _calibration(self):
        from baxter_dynamics_ros.estimation.settings import PredictorSettings
        from baxter_dynamics_ros.recordings.parameter_file import write_parameters
        path = self.folder / CALIBRATION
        if not path.exists():
            write_parameters(path, PredictorSettings({
                'arm': 'right', 'effort_model.bias': [0.1] * 7, 'payload.mass': 0.2}).values)
        return path

    def _arrays(self, path):
        """Make an .npz file of recordings, as docs/evaluate.md describes it."""
        t = 0.01 * np.arange(1500)[:, None]  # [s]
        phase = np.arange(7.0)
        w = 2 * np.pi * (0.2 + 0.05 * phase)  # [rad/s]
        one = np.ones(len(t), int)
        q, qd = 0.5 * np.sin(w * t + phase), 0.5 * w * np.cos(w * t + phase)
        effort = q + 0.3 * np.tanh(qd / 0.05)
        np.savez(path, joint_names=list(JOINTS), period=0.01, position=q, velocity=qd,
                 effort=effort, recording=0 * one, recording_names=[path.stem])


def _kind(path, word):
    if word in OUTPUTS or not path.exists():
        return word
    return path.suffix if path.is_file() else '/'


def _copy(source, target):
    if source.is_dir():
        shutil.copytree(source, target, dirs_exist_ok=True)
    else:
        shutil.copy2(source, target)

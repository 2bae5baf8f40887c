"""pip install . with no extra: the model on any machine, with NumPy alone."""

import json
import os
from pathlib import Path
import shutil
import subprocess
import sys

from baxter_dynamics_ros import __version__, BaxterArm
import numpy as np
import pytest

NAME = 'baxter_dynamics_ros'
REPOSITORY = Path(__file__).resolve().parents[1]

# What would let this environment leak into the new one. The first two belong together: a child
# of the ROS wheels must inherit both or neither.
LEAKS = ('LD_LIBRARY_PATH', '_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'PYTHONPATH', 'VIRTUAL_ENV',
         'PYTHONDONTWRITEBYTECODE')

pytestmark = pytest.mark.timeout(300)


class Venv:
    """A new virtual environment without pip, used from a folder outside the checkout."""

    def __init__(self, folder):
        self.prefix = folder / 'venv'
        self._folder = folder
        self._run(sys.executable, '-m', 'venv', '--without-pip', self.prefix).check_returncode()

    def run(self, command, *arguments):
        """Run a command of the environment."""
        return self._run(self.prefix / 'bin' / command, *arguments)

    def pip(self, *arguments):
        """Run this interpreter's pip for the environment."""
        return self._run(sys.executable, '-m', 'pip', '--python', self.prefix, *arguments)

    def _run(self, *command):
        environment = {name: value for name, value in os.environ.items() if name not in LEAKS}
        environment['CFLAGS'] = '-O0'  # the extension in a fraction of the time
        return subprocess.run(command, cwd=self._folder, env=environment, timeout=240,
                              capture_output=True, text=True)


@pytest.fixture(scope='module')
def venv(tmp_path_factory):
    """Return an environment into which a copy of the checkout was installed."""
    pytest.importorskip('pip', minversion='22.3', reason='pip knows --python since 22.3')
    folder = tmp_path_factory.mktemp('install')
    result = Venv(folder)
    source = folder / 'source'  # the checkout stays clean
    shutil.copytree(REPOSITORY, source, symlinks=True, ignore=shutil.ignore_patterns(
        '.*', '__pycache__', '*.egg-info', '*.so', 'build', 'install', 'log', 'venv'))
    pip = result.pip('install', '--no-compile', source)
    if pip.returncode and result.pip('download', '--no-deps', 'setuptools').returncode:
        pytest.skip('pip reaches no package index')
    assert pip.returncode == 0, pip.stdout + pip.stderr
    shutil.rmtree(source)  # what was installed stands by itself
    return result


def test_brings_numpy_alone(venv):
    answer = venv.pip('list', '--format=json')
    names = {entry['name'].replace('-', '_') for entry in json.loads(answer.stdout)}
    assert names == {NAME, 'numpy'}


def test_model_runs(venv):
    answer = venv.run('python', '-c', f'import {NAME} as b; print(b.__file__); '
                      'print(b.BaxterArm().gravity([0.0] * 7).tolist()); '
                      'print(b.BaxterArm().engine)')
    file, gravity, engine = answer.stdout.splitlines()
    assert engine == ('compiled' if shutil.which('c++') else 'python')
    assert venv.prefix in Path(file).parents
    np.testing.assert_allclose(json.loads(gravity), BaxterArm().gravity([0.0] * 7), rtol=1e-12)


def test_command_runs(venv):
    answer = venv.run('baxter_dynamics', '--version')
    assert (answer.returncode, answer.stdout.strip()) == (0, __version__)


def test_exports_need_nothing_else(venv, tmp_path):
    answer = venv.run('baxter_dynamics', 'export', 'c', '-o', tmp_path)
    assert (answer.returncode, answer.stderr) == (0, '')
    assert (tmp_path / 'example.c').is_file()


@pytest.mark.parametrize('executable', ['fake_baxter', 'joint_state_bridge', 'torque_predictor'])
def test_nodes_are_on_the_path(venv, executable):
    assert os.access(venv.prefix / 'bin' / executable, os.X_OK)


@pytest.mark.parametrize('executable', ['torque_predictor', 'joint_state_bridge', 'fake_baxter'])
def test_nodes_name_the_extra_they_need(venv, executable):
    answer = venv.run(executable)
    assert answer.returncode == 1
    assert answer.stderr.startswith(f'{executable}: ') and 'pip install ".[ros]"' in answer.stderr
    assert len(answer.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize('arguments, extra', [
    ('demo', 'demo'), ('experiment lift', 'demo'), ('calibrate --plan', 'offline'),
    ('evaluate run', 'offline'), ('calibrate run', 'offline')])
def test_commands_name_the_extra_they_need(venv, arguments, extra):
    answer = venv.run('baxter_dynamics', *arguments.split())
    assert answer.returncode == 1
    assert answer.stdout == ''
    line, = answer.stderr.splitlines()
    assert line.startswith('baxter_dynamics: No module named ')
    assert f'install the {extra} extra: pip install ".[{extra}]"' in line


@pytest.mark.parametrize('pattern', ['package.xml', 'config/*.yaml', 'launch/*.launch.xml'])
def test_shared_files_are_installed(venv, pattern):
    files = list(REPOSITORY.glob(pattern))
    assert files
    for file in files:
        assert (venv.prefix / 'share' / NAME / file.relative_to(REPOSITORY)).is_file()

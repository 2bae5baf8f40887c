"""pip install . without an extra: the model with NumPy alone."""

import importlib.metadata
import json
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys

from baxter_dynamics_ros import __version__, BaxterArm
import numpy as np
import pytest

NAME = 'baxter_dynamics_ros'
REPOSITORY = Path(__file__).resolve().parents[1]

# These would let this environment leak into the new one. The first two belong together: a child
# of the ROS wheels must inherit both or neither.
LEAKS = ('LD_LIBRARY_PATH', '_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'PYTHONPATH', 'VIRTUAL_ENV',
         'PYTHONDONTWRITEBYTECODE')
# Nothing is downloaded: this environment builds the wheel, and lends its NumPy.
OFFLINE = '--no-deps', '--no-index', '--quiet'

pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope='module')
def venv(tmp_path_factory):
    """Return a function that runs a command of a new environment with NumPy and the package."""
    pytest.importorskip('pip', minversion='22.3', reason='pip knows --python since 22.3')
    pytest.importorskip('pybind11', reason='the build needs pybind11: pip install ".[test]"')
    if int(importlib.metadata.version('setuptools').split('.')[0]) < 71:
        pytest.skip('setuptools makes no wheels: pip install ".[test]"')
    folder = tmp_path_factory.mktemp('install')
    environment = {name: value for name, value in os.environ.items() if name not in LEAKS}
    environment.update(CFLAGS='-O0', CXXFLAGS='-O0')  # the extension in a fraction of the time

    def run(*command):
        return subprocess.run(command, cwd=folder, env=environment, timeout=240,
                              capture_output=True, text=True)

    source, prefix = folder / 'source', folder / 'venv'
    shutil.copytree(REPOSITORY, source, symlinks=True, ignore=shutil.ignore_patterns(
        '.*', '__pycache__', '*.egg-info', '*.so', 'build', 'install', 'log', 'venv'))
    for command in (
            ('venv', '--without-pip', prefix),
            ('pip', 'wheel', *OFFLINE, '--no-build-isolation', '-w', folder, source)):
        answer = run(sys.executable, '-m', *command)
        assert answer.returncode == 0, answer.stdout + answer.stderr
    wheel, = folder.glob('*.whl')
    answer = run(sys.executable, '-m', 'pip', '--python', prefix, 'install', '--no-compile',
                 *OFFLINE, wheel)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    packages, = prefix.glob('lib/python*/site-packages')
    for entry in {path.parts[0] for path in importlib.metadata.files('numpy')} - {'..'}:
        (packages / entry).symlink_to(Path(np.__file__).parents[1] / entry)
    shutil.rmtree(source)  # the installed package stands by itself
    return lambda command, *arguments: run(prefix / 'bin' / command, *arguments)


def test_model_and_exports_need_numpy_alone(venv):
    answer = venv('python', '-c', f"""
import importlib.metadata, json, {NAME} as b
print(json.dumps([importlib.metadata.requires('{NAME}'), b.__file__, b.BaxterArm().engine,
                  b.BaxterArm().gravity([0.0] * 7).tolist()]))
""")
    requirements, file, engine, gravity = json.loads(answer.stdout)
    needed = [line.partition('>')[0] for line in requirements if 'extra ==' not in line]
    assert needed == ['numpy']
    # colcon test runs pytest only if the extra 'test' has it.
    assert any(re.match('pytest==.*extra == .test', line) for line in requirements)
    assert '/venv/lib/' in file
    assert engine == ('compiled' if shutil.which('c++') else 'python')
    np.testing.assert_allclose(gravity, BaxterArm().gravity([0.0] * 7), rtol=1e-12)
    answer = venv('baxter_dynamics', '--version')
    assert (answer.returncode, answer.stdout.strip()) == (0, __version__)
    answer = venv('baxter_dynamics', 'export', 'c', '-o', 'closed_form')
    assert (answer.returncode, answer.stderr) == (0, '')


@pytest.mark.parametrize('command, extra', [
    ('torque_predictor', 'ros'), ('joint_state_bridge', 'ros'), ('fake_baxter', 'ros'),
    ('baxter_dynamics demo', 'demo'), ('baxter_dynamics experiment lift', 'demo'),
    ('baxter_dynamics calibrate --plan', 'offline'), ('baxter_dynamics evaluate run', 'offline')])
def test_commands_name_the_extra_they_need(venv, command, extra):
    answer = venv(*command.split())
    assert (answer.returncode, answer.stdout) == (1, '')
    line, = answer.stderr.splitlines()
    assert line.startswith(command.split()[0]) and f'pip install ".[{extra}]"' in line

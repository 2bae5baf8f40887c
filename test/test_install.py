"""pip installs the model with NumPy alone; colcon installs what ros2 run and ros2 launch need."""

import importlib.metadata
from importlib.util import find_spec
import json
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
import sysconfig

from baxter_dynamics_ros import __version__, BaxterArm
import numpy as np
import pytest

NAME = 'baxter_dynamics_ros'
INTERFACES = 'baxter_dynamics_interfaces'
REPOSITORY = Path(__file__).resolve().parents[1]
EXECUTABLES = ('baxter_dynamics', 'fake_baxter', 'joint_state_bridge', 'torque_predictor')

pytestmark = pytest.mark.timeout(300)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a colcon workspace with a copy of the repository."""
    folder = tmp_path_factory.mktemp('install')
    shutil.copytree(REPOSITORY, folder / 'src' / NAME, symlinks=True,
                    ignore=shutil.ignore_patterns('.*', '__pycache__', '*.egg-info', '*.so',
                                                  'build', 'install', 'log', 'venv'))
    return folder


@pytest.fixture(scope='module')
def run(folder):
    """Return a function that runs a command in the workspace, where no compiler works."""
    # This interpreter's tools first, as in a virtual environment that need not be active.
    path = os.pathsep.join([sysconfig.get_path('scripts'), os.environ['PATH']])
    environment = {**os.environ, 'PATH': path, 'COLCON_HOME': str(folder / 'home'),
                   'CC': 'false', 'CXX': 'false'}

    def run(*command, check=True, **variables):
        done = subprocess.run(command, cwd=folder, env={**environment, **variables}, timeout=240,
                              capture_output=True, text=True)
        assert done.returncode == 0 or not check, done.stdout + done.stderr
        return done

    return run


@pytest.fixture(scope='module')
def installed(folder, run):
    """Return a function that runs Python code or a command beside the package and NumPy alone."""
    pytest.importorskip('pip', reason='installing needs pip')
    pytest.importorskip('pybind11', reason='the build needs pybind11: pip install ".[test]"')
    if int(importlib.metadata.version('setuptools').split('.')[0]) < 71:
        pytest.skip('setuptools makes no wheels: pip install ".[test]"')
    site = folder / 'site'
    run(sys.executable, '-m', 'pip', 'install', '--quiet', '--no-deps', '--no-index',
        '--no-build-isolation', '--no-compile', '--target', site, folder / 'src' / NAME)
    for entry in {path.parts[0] for path in importlib.metadata.files('numpy')} - {'..'}:
        (site / entry).symlink_to(Path(np.__file__).parents[1] / entry)
    # -S: without the packages of this environment
    return lambda *arguments: run(sys.executable, '-S', *arguments, check=False,
                                  PYTHONPATH=str(site))


@pytest.fixture(scope='module')
def prefix(folder, run):
    """Return the folder into which colcon installs the package."""
    pytest.importorskip('colcon_ros', reason='colcon_ros is missing: pip install ".[test]"')
    output = run('colcon', '--log-base', 'log', 'build', '--base-paths', 'src').stdout
    assert 'implicitly' not in output  # colcon installs the index and manifest if setup.py forgets
    return folder / 'install' / NAME


def test_model_and_exports_need_numpy_alone(installed):
    answer = json.loads(installed('-c', f"""
import importlib.metadata, json, {NAME} as b
print(json.dumps([importlib.metadata.requires('{NAME}'), b.__file__, b.BaxterArm().engine,
                  b.BaxterArm().gravity([0.0] * 7).tolist()]))
""").stdout)
    requirements, file, engine, gravity = answer
    needed = [line.partition('>')[0] for line in requirements if 'extra ==' not in line]
    assert needed == ['numpy']
    # colcon test runs pytest only if the extra 'test' has it.
    assert any(re.match('pytest==.*extra == .test', line) for line in requirements)
    assert '/site/' in file and engine == 'python'
    np.testing.assert_allclose(gravity, BaxterArm().gravity([0.0] * 7), rtol=1e-12)
    for language in ('c', 'latex'):
        exported = installed('site/bin/baxter_dynamics', 'export', language, '-o', language)
        assert (exported.returncode, exported.stderr) == (0, '')


def test_with_a_compiler_the_extension_is_built():
    if shutil.which('c++'):
        assert find_spec(f'{NAME}.model._compiled')


@pytest.mark.parametrize('command, extra', [
    ('torque_predictor', 'ros'), ('joint_state_bridge', 'ros'), ('fake_baxter', 'ros'),
    ('baxter_dynamics demo', 'demo'), ('baxter_dynamics experiment lift', 'demo'),
    ('baxter_dynamics calibrate --plan', 'offline'), ('baxter_dynamics evaluate run', 'offline')])
def test_commands_name_the_extra_they_need(installed, command, extra):
    answer = installed(*f'site/bin/{command}'.split())
    assert (answer.returncode, answer.stdout) == (1, '')
    line, = answer.stderr.splitlines()
    assert line.startswith(command.split()[0]) and f'pip install ".[{extra}]"' in line


def test_a_build_without_the_interfaces_says_how_to_build_both(folder, run):
    source = folder / 'src' / NAME
    script = (f'import os, runpy, sys; os.chdir("{source}"); sys.modules["{INTERFACES}"] = None; '
              'sys.argv[:] = ["setup.py", "install", "--help"]; runpy.run_path("setup.py")')
    assert f'--base-paths {source} {source}/{INTERFACES}\n' in run(
        sys.executable, '-c', script).stderr


def test_the_interfaces_are_built_first(folder, run, prefix):
    source = folder / 'src' / NAME
    packages = run('colcon', '--log-base', 'log', 'list', '--base-paths', source,
                   source / INTERFACES, '--topological-order', '--names-only').stdout
    assert packages.split() == [INTERFACES, NAME]


def test_files_are_where_ros2_run_and_launch_look(folder, prefix):
    assert (prefix / 'share/ament_index/resource_index/packages' / NAME).is_file()
    for executable in EXECUTABLES:
        assert os.access(prefix / 'lib' / NAME / executable, os.X_OK)
    for pattern in ('package.xml', 'config/*.*', 'launch/*.launch.xml'):
        files = list((folder / 'src' / NAME).glob(pattern))
        assert files
        for file in files:
            installed = prefix / 'share' / NAME / file.relative_to(folder / 'src' / NAME)
            assert installed.read_bytes() == file.read_bytes()


def test_the_command_runs_from_the_workspace(folder, run, prefix):
    version, file = run(
        'sh', '-c', '. "$1" && "$2" --version && "$3" -c "$4"', 'sh', prefix.parent / 'setup.sh',
        prefix / 'lib' / NAME / 'baxter_dynamics', sys.executable,
        f'import {NAME}; print({NAME}.__file__)').stdout.splitlines()
    assert version == __version__
    assert folder in Path(file).parents  # not another one that pip has installed

"""A real colcon build, and the layout that ros2 run and ros2 launch look for."""

import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig

import baxter_dynamics_ros
import pytest

NAME = 'baxter_dynamics_ros'
INTERFACES = 'baxter_dynamics_interfaces'
REPOSITORY = Path(__file__).resolve().parents[1]
EXECUTABLES = ('baxter_dynamics', 'fake_baxter', 'joint_state_bridge', 'torque_predictor')

pytestmark = pytest.mark.timeout(300)


class Workspace:
    """A colcon workspace with a copy of the repository: the checkout stays clean."""

    def __init__(self, folder):
        self.folder = folder
        self.source = folder / 'src' / NAME
        shutil.copytree(REPOSITORY, self.source, symlinks=True, ignore=shutil.ignore_patterns(
            '.*', '__pycache__', '*.egg-info', '*.so', 'build', 'install', 'log', 'venv'))
        # This interpreter's tools first, as in a virtual environment that need not be active.
        self.path = os.pathsep.join([sysconfig.get_path('scripts'), os.environ['PATH']])
        self.environment = {**os.environ, 'PATH': self.path, 'COLCON_HOME': str(folder / 'home'),
                            'CC': 'false', 'CXX': 'false'}  # no extension: test_install.py has it

    def colcon(self, *arguments):
        """Run colcon and return its output."""
        return self.run(shutil.which('colcon', path=self.path), '--log-base', 'log', *arguments)

    def run(self, *command):
        """Run a command in the workspace and return its output."""
        result = subprocess.run(command, cwd=self.folder, env=self.environment, timeout=240,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert result.returncode == 0, result.stdout
        return result.stdout


@pytest.fixture(scope='module')
def workspace(tmp_path_factory):
    pytest.importorskip('colcon_ros', reason='colcon_ros is missing: pip install ".[test]"')
    return Workspace(tmp_path_factory.mktemp('workspace'))


@pytest.fixture(scope='module', params=['copied', 'symlinked'])
def prefix(request, workspace):
    """Return the prefix of the installed package, by each of the two ways to install it."""
    base = workspace.folder / request.param
    option = ['--symlink-install'] if request.param == 'symlinked' else []
    output = workspace.colcon('build', '--build-base', base / 'build',
                              '--install-base', base / 'install', *option)
    assert 'implicitly' not in output  # colcon installs the index and manifest if setup.py forgets
    assert '--base-paths' not in output
    return base / 'install' / NAME


def test_building_the_package_builds_the_interfaces_first(workspace):
    packages = workspace.colcon('list', '--base-paths', workspace.source,
                                workspace.source / INTERFACES, '--topological-order',
                                '--names-only', '--packages-up-to', NAME)
    assert packages.split() == [INTERFACES, NAME]


def test_a_build_without_the_interfaces_says_how_to_build_both(workspace):
    script = (f'import runpy, sys; sys.modules["{INTERFACES}"] = None; '  # as if not installed
              'sys.argv[:] = ["setup.py", "install", "--help"]; runpy.run_path("setup.py")')
    output = workspace.run('sh', '-c', 'cd "$1" && "$2" -c "$3"', 'sh', workspace.source,
                           sys.executable, script)
    assert f'--base-paths {workspace.source} {workspace.source}/{INTERFACES}\n' in output


def test_files_are_where_ros2_run_and_launch_look(workspace, prefix):
    assert (prefix / 'share/ament_index/resource_index/packages' / NAME).is_file()
    for executable in EXECUTABLES:
        assert os.access(prefix / 'lib' / NAME / executable, os.X_OK)
    for pattern in ('package.xml', 'config/*.*', 'launch/*.launch.xml'):
        files = list(workspace.source.glob(pattern))
        assert files
        for file in files:
            installed = prefix / 'share' / NAME / file.relative_to(workspace.source)
            assert installed.read_bytes() == file.read_bytes()


def test_the_command_runs_from_the_workspace(workspace, prefix):
    output = workspace.run(
        'sh', '-c', '. "$1" && "$2" --version && "$3" -c "$4"', 'sh', prefix.parent / 'setup.sh',
        prefix / 'lib' / NAME / 'baxter_dynamics', sys.executable,
        f'import {NAME}; print({NAME}.__file__)')
    version, file = output.splitlines()
    assert version == baxter_dynamics_ros.__version__
    assert workspace.folder in Path(file).parents  # not another one that pip has installed

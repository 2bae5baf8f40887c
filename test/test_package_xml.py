"""Manifests, setup.py, imports, launch files and parameter files agree."""

import ast
import importlib
from pathlib import Path
import re
import sys
import xml.etree.ElementTree as ET

import baxter_dynamics_ros
from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings
import pytest

NAME = 'baxter_dynamics_ros'
REPOSITORY = Path(__file__).resolve().parents[1]
INTERFACES = REPOSITORY / 'baxter_dynamics_interfaces'
CONFIG = sorted((REPOSITORY / 'config').glob('*.yaml'))
LAUNCH = sorted((REPOSITORY / 'launch').glob('*.launch.xml'))
SETUP = ast.parse((REPOSITORY / 'setup.py').read_text('utf-8'))

# Imported name: rosdep's key, where it differs; None for what has no key or comes with another.
ROSDEP = {
    'jinja2': 'python3-jinja2',
    'matplotlib': 'python3-matplotlib',
    'mcap': 'mcap-ros2-support',
    'mujoco': 'python3-mujoco-pip',
    'numpy': 'python3-numpy',
    'rich': 'python3-rich',
    'rosbags': 'python3-rosbags-pip',
    'scipy': 'python3-scipy',
    'trimesh': None,
    'viser': None,
    'yaml': 'python3-yaml',
    'yourdfpy': None,
    'zstandard': None,
}
NOT_IMPORTED = {'ros2launch'}  # needed, to read the launch files


@pytest.fixture
def manifest():
    """Return a function that parses a folder's package.xml."""
    package = pytest.importorskip('catkin_pkg.package', reason='catkin_pkg is missing: '
                                  'pip install catkin_pkg')

    def parse(folder):
        warnings = []
        result = package.parse_package(str(folder / 'package.xml'), warnings=warnings)
        assert not warnings
        return result
    return parse


def test_manifests_and_setup_py_agree(manifest):
    package, interfaces, pyproject = manifest(REPOSITORY), manifest(INTERFACES), _pyproject()
    assert [each.get_build_type() for each in (package, interfaces)] == [
        'ament_python', 'ament_cmake']
    assert {each.package_format for each in (package, interfaces)} == {3}
    assert [package.name, interfaces.name] == [NAME, pyproject['project']['name']]
    assert {package.version, interfaces.version, _setup('version'),
            pyproject['project']['version'],
            re.search('^version: (.*)$', (REPOSITORY / 'CITATION.cff').read_text(), re.M)[1]
            } == {baxter_dynamics_ros.__version__}
    (license_,), (maintainer,) = package.licenses, package.maintainers
    assert [_setup('license'), interfaces.licenses] == [license_, [license_]]
    assert [_setup('maintainer'), _setup('maintainer_email')] == [
        maintainer.name, maintainer.email]


def test_imports_are_declared_and_nothing_else_is(manifest):
    names = {ROSDEP.get(name, name) for name in _imported()} - {None}
    assert {depend.name for depend in manifest(REPOSITORY).exec_depends} == names | NOT_IMPORTED


def test_interface_types_are_declared(manifest):
    files = sorted(INTERFACES.glob('srv/*.srv')) + sorted(INTERFACES.glob('action/*.action'))
    used = {package for file in files for package in
            re.findall(r'^(\w+)/\w+', file.read_text('utf-8'), re.MULTILINE)}
    assert used
    assert used <= {depend.name for depend in manifest(INTERFACES).build_depends}
    assert used <= {depend.name for depend in manifest(INTERFACES).exec_depends}
    cmake = (INTERFACES / 'CMakeLists.txt').read_text('utf-8')
    assert used <= set(re.findall(r'find_package\((\w+) REQUIRED\)', cmake))
    assert set(re.findall(r'\w+/\w+\.(?:srv|action)', cmake)) == {
        f'{file.parent.name}/{file.name}' for file in files}


def test_console_scripts_name_functions():
    for entry in _setup('entry_points')['console_scripts']:
        module, function = entry.split(' = ')[1].split(':')
        assert callable(getattr(importlib.import_module(module), function)), entry


@pytest.mark.parametrize('path', LAUNCH, ids=lambda path: path.name)
def test_names_in_launch_files_exist(path):
    topics = pytest.importorskip(f'{NAME}.nodes.topics', reason='ROS is not installed')
    root = ET.parse(path).getroot()
    scripts = {entry.split(' = ')[0] for entry in _setup('entry_points')['console_scripts']}
    assert {node.get('pkg') for node in root.iter('node')} == {NAME}
    assert {node.get('exec') for node in root.iter('node')} <= scripts
    share = f'$(find-pkg-share {NAME})/'
    files = {value[len(share):] for element in root.iter() for value in element.attrib.values()
             if value.startswith(share)}
    assert files and all((REPOSITORY / name).is_file() for name in files)
    assert (set(re.findall(r'\$\(var (\w+)\)', path.read_text('utf-8')))
            == {argument.get('name') for argument in root.findall('arg')})
    for include in root.findall('include'):
        included = ET.parse(REPOSITORY / 'launch' / Path(include.get('file')).name)
        assert ({argument.get('name') for argument in include.findall('arg')}
                <= {argument.get('name') for argument in included.findall('arg')})
    assert {remap.get('from') for remap in root.iter('remap')} <= {topics.JOINT_STATES}
    assert {parameter.get('name') for node in root.findall('.//node[@exec="torque_predictor"]')
            for parameter in node.findall('param[@name]')} <= DEFAULTS.keys()


@pytest.mark.parametrize('path', CONFIG, ids=lambda path: path.name)
def test_parameter_files_are_accepted_and_have_the_types_of_ros(path):
    values = _parameters(path)
    assert values
    PredictorSettings.from_parameters(values)  # raises for an unknown name or a refused value
    for name, value in values.items():
        assert _type(value) == _type(DEFAULTS[name]), name


def test_parameter_file_of_the_right_arm_lists_all_defaults():
    values = _parameters(REPOSITORY / 'config' / 'right_arm.yaml')
    assert PredictorSettings.from_parameters(values).parameters() == DEFAULTS
    assert values.keys() == DEFAULTS.keys()


def _setup(keyword):
    """Return a literal argument of the call of setup()."""
    call = next(node for node in ast.walk(SETUP) if isinstance(node, ast.Call)
                and getattr(node.func, 'id', None) == 'setup')
    return ast.literal_eval(next(argument.value for argument in call.keywords
                                 if argument.arg == keyword))


def _pyproject():
    tomllib = pytest.importorskip('tomllib', reason='tomllib comes with Python 3.11')
    return tomllib.loads((INTERFACES / 'pyproject.toml').read_text('utf-8'))


def _imported():
    """Return the packages that the code imports, beside itself and the standard library."""
    names = set()
    for path in (REPOSITORY / NAME).rglob('*.py'):
        for node in ast.walk(ast.parse(path.read_text('utf-8'))):
            if isinstance(node, ast.Import):
                names |= {alias.name.split('.')[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names.add(node.module.split('.')[0])
    return names - sys.stdlib_module_names - {NAME}


def _parameters(path):
    """Return a parameter file as parameter name to value."""
    pytest.importorskip('yaml', reason='PyYAML is missing: pip install pyyaml')
    from baxter_dynamics_ros.recordings.parameter_file import read_parameters
    return read_parameters(path, '/any/node', warn=pytest.fail)


def _type(value):
    return [type(item) for item in value] if isinstance(value, (list, tuple)) else type(value)

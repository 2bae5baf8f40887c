"""What is said twice agrees: manifests, setup.py, imports, launch files, parameter files."""

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

# Imported name -> rosdep's name, where that is another; None for what is optional, most of which
# Ubuntu has no package of.
ROSDEP = {
    'jinja2': 'python3-jinja2',
    'matplotlib': 'python3-matplotlib',
    'mcap': None,
    'mujoco': None,
    'numpy': 'python3-numpy',
    'rich': 'python3-rich',
    'rosbags': None,
    'scipy': 'python3-scipy',
    'yaml': 'python3-yaml',
    'zstandard': None,
}
# Needed, and imported by nobody: what reads the launch files.
NOT_IMPORTED = {'ros2launch'}


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


@pytest.mark.parametrize('folder, build_type', [
    (REPOSITORY, 'ament_python'), (INTERFACES, 'ament_cmake')], ids=[NAME, INTERFACES.name])
def test_manifest(manifest, folder, build_type):
    package = manifest(folder)
    assert package.package_format == 3
    assert package.name == (NAME if folder == REPOSITORY else INTERFACES.name)
    assert package.get_build_type() == build_type
    assert package.licenses == ['Apache-2.0']


def test_one_version(manifest):
    assert {manifest(REPOSITORY).version, manifest(INTERFACES).version,
            _setup('version'), _pyproject()['project']['version'],
            re.search('^version: (.*)$', (REPOSITORY / 'CITATION.cff').read_text(), re.M)[1]
            } == {baxter_dynamics_ros.__version__}


def test_setup_py_says_what_package_xml_says(manifest):
    package = manifest(REPOSITORY)
    assert [_setup('maintainer'), _setup('maintainer_email')] == [
        package.maintainers[0].name, package.maintainers[0].email]
    assert _setup('license') == package.licenses[0]


def test_imports_are_declared_and_nothing_else_is(manifest):
    names = {ROSDEP.get(name, name) for name in _imported()} - {None}
    assert {depend.name for depend in manifest(REPOSITORY).exec_depends} == names | NOT_IMPORTED


def test_interface_types_are_declared(manifest):
    files = sorted(INTERFACES.glob('srv/*.srv'))
    used = {package for file in files for package in
            re.findall(r'^(\w+)/\w+', file.read_text('utf-8'), re.MULTILINE)}
    assert used
    assert used <= {depend.name for depend in manifest(INTERFACES).build_depends}
    assert used <= {depend.name for depend in manifest(INTERFACES).exec_depends}
    cmake = (INTERFACES / 'CMakeLists.txt').read_text('utf-8')
    for package in used:
        assert f'find_package({package} REQUIRED)' in cmake
    assert set(re.findall(r'srv/\w+\.srv', cmake)) == {f'srv/{file.name}' for file in files}


def test_wheels_of_both_packages_have_the_same_versions():
    both = {}
    pyproject = _pyproject()
    for requirement in (*(node.value for node in ast.walk(SETUP) if isinstance(node, ast.Constant)
                          and isinstance(node.value, str)),
                        *pyproject['build-system']['requires'],
                        *pyproject['project']['dependencies']):
        name, pinned, version = requirement.partition('==')
        if pinned:
            both.setdefault(name, set()).add(version)
    assert 'ros-jazzy-common-interfaces' in both
    assert {name: versions for name, versions in both.items() if len(versions) > 1} == {}


@pytest.mark.parametrize('path', LAUNCH, ids=lambda path: path.name)
def test_executables_of_launch_files_exist(path):
    scripts = {entry.split(' = ')[0] for entry in _setup('entry_points')['console_scripts']}
    nodes = ET.parse(path).findall('.//node')
    assert nodes
    for node in nodes:
        assert node.get('pkg') == NAME
        assert node.get('exec') in scripts


def test_console_scripts_name_functions():
    for entry in _setup('entry_points')['console_scripts']:
        module, function = entry.split(' = ')[1].split(':')
        assert callable(getattr(importlib.import_module(module), function)), entry


@pytest.mark.parametrize('path', LAUNCH, ids=lambda path: path.name)
def test_files_of_launch_files_exist(path):
    share = f'$(find-pkg-share {NAME})/'
    named = [value[len(share):] for element in ET.parse(path).iter()
             for value in element.attrib.values() if value.startswith(share)]
    assert named
    for name in named:
        assert (REPOSITORY / name).is_file(), name


@pytest.mark.parametrize('path', LAUNCH, ids=lambda path: path.name)
def test_arguments_of_launch_files_are_declared(path):
    root = ET.parse(path)
    declared = {argument.get('name') for argument in root.findall('arg')}
    used = set(re.findall(r'\$\(var (\w+)\)', path.read_text('utf-8')))
    assert used == declared
    for include in root.findall('include'):
        included = ET.parse(REPOSITORY / 'launch' / Path(include.get('file')).name)
        assert ({argument.get('name') for argument in include.findall('arg')}
                <= {argument.get('name') for argument in included.findall('arg')})


@pytest.mark.parametrize('path', LAUNCH, ids=lambda path: path.name)
def test_topics_and_parameters_of_launch_files_exist(path):
    topics = pytest.importorskip(f'{NAME}.nodes.topics', reason='ROS is not installed')
    for remap in ET.parse(path).findall('.//remap'):
        assert remap.get('from') == topics.JOINT_STATES
    for node in ET.parse(path).findall('.//node[@exec="torque_predictor"]'):
        for parameter in node.findall('param[@name]'):
            assert parameter.get('name') in DEFAULTS


@pytest.mark.parametrize('path', CONFIG, ids=lambda path: path.name)
def test_parameter_files_are_accepted(path):
    values = _parameters(path)
    assert values
    PredictorSettings.from_parameters(values)  # raises at an unknown name or a refused value


@pytest.mark.parametrize('path', CONFIG, ids=lambda path: path.name)
def test_parameter_files_have_the_types_that_ros_insists_on(path):
    values = _parameters(path)
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

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
SCRIPTS = re.findall(r"'(\w+) = ([\w.]+):(\w+)'", (REPOSITORY / 'setup.py').read_text('utf-8'))

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


def manifest(folder):
    """Return a function that returns the texts of the elements of a manifest with a tag."""
    root = ET.parse(folder / 'package.xml').getroot()
    return lambda *tags: {element.text for tag in tags for element in root.iter(tag)}


def test_versions_names_and_licenses_agree():
    texts = {path: (REPOSITORY / path).read_text('utf-8') for path in (
        'package.xml', 'setup.py', 'CITATION.cff', 'baxter_dynamics_interfaces/package.xml',
        'baxter_dynamics_interfaces/pyproject.toml')}
    for path, text in texts.items():
        found = re.search(r'^\s*(?:<version>|version ?[:=] ?[\'"]?)([\d.]+)', text, re.MULTILINE)
        assert found[1] == baxter_dynamics_ros.__version__, path
    package, interfaces = manifest(REPOSITORY), manifest(INTERFACES)
    assert package('name') == {NAME} and interfaces('name') == {'baxter_dynamics_interfaces'}
    for (value,) in (package('license'), package('maintainer')):
        assert f"'{value}'" in texts['setup.py']
    assert package('license') == interfaces('license')


def test_imports_are_declared_and_nothing_else_is():
    names = {ROSDEP.get(name, name) for name in _imported()} - {None}
    assert manifest(REPOSITORY)('exec_depend') == names | NOT_IMPORTED


def test_interface_types_are_declared():
    files = sorted(INTERFACES.glob('srv/*.srv')) + sorted(INTERFACES.glob('action/*.action'))
    used = {package for file in files for package in
            re.findall(r'^(\w+)/\w+', file.read_text('utf-8'), re.MULTILINE)}
    assert used and used <= manifest(INTERFACES)('depend')
    cmake = (INTERFACES / 'CMakeLists.txt').read_text('utf-8')
    assert used <= set(re.findall(r'find_package\((\w+) REQUIRED\)', cmake))
    assert set(re.findall(r'\w+/\w+\.(?:srv|action)', cmake)) == {
        f'{file.parent.name}/{file.name}' for file in files}


def test_console_scripts_name_functions():
    assert len(SCRIPTS) == 4
    for _, module, function in SCRIPTS:
        assert callable(getattr(importlib.import_module(module), function)), function


@pytest.mark.parametrize('path', LAUNCH, ids=lambda path: path.name)
def test_names_in_launch_files_exist(path):
    topics = pytest.importorskip(f'{NAME}.nodes.topics', reason='ROS is not installed')
    root = ET.parse(path).getroot()
    assert {node.get('pkg') for node in root.iter('node')} == {NAME}
    assert {node.get('exec') for node in root.iter('node')} <= {name for name, *_ in SCRIPTS}
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
    pytest.importorskip('yaml', reason='PyYAML is missing: pip install pyyaml')
    from baxter_dynamics_ros.recordings.parameter_file import read_parameters
    values = read_parameters(path, '/any/node', warn=pytest.fail)
    assert values
    settings = PredictorSettings.from_parameters(values)  # raises for a wrong name or value
    for name, value in values.items():
        assert _type(value) == _type(DEFAULTS[name]), name
    if path.name == 'right_arm.yaml':  # lists all defaults
        assert values.keys() == DEFAULTS.keys() and settings.parameters() == DEFAULTS


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


def _type(value):
    return [type(item) for item in value] if isinstance(value, (list, tuple)) else type(value)

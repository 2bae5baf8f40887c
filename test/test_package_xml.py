"""Manifests, setup.py, launch files, parameter files and layouts agree."""

import importlib
import json
from pathlib import Path
import re
import xml.etree.ElementTree as ET

import baxter_dynamics_ros
from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names, JOINTS
import pytest

NAME = 'baxter_dynamics_ros'
REPOSITORY = Path(__file__).resolve().parents[1]
INTERFACES = REPOSITORY / 'baxter_dynamics_interfaces'
CONFIG = sorted((REPOSITORY / 'config').glob('*.yaml'))
LAUNCH = sorted((REPOSITORY / 'launch').glob('*.launch.xml'))
NODE = '/torque_predictor/'
SCRIPTS = re.findall(r"'(\w+) = ([\w.]+):(\w+)'", (REPOSITORY / 'setup.py').read_text('utf-8'))


def manifest(folder, tag):
    """Return the texts of the elements of a manifest with a tag."""
    return {element.text for element in ET.parse(folder / 'package.xml').iter(tag)}


def test_versions_names_and_licenses_agree():
    texts = {path: (REPOSITORY / path).read_text('utf-8') for path in (
        'package.xml', 'setup.py', 'CITATION.cff', 'baxter_dynamics_interfaces/package.xml',
        'baxter_dynamics_interfaces/pyproject.toml')}
    for path, text in texts.items():
        found = re.search(r'^\s*(?:<version>|version ?[:=] ?[\'"]?)([\d.]+)', text, re.MULTILINE)
        assert found[1] == baxter_dynamics_ros.__version__, path
    assert manifest(REPOSITORY, 'name') == {NAME}
    assert manifest(INTERFACES, 'name') == {'baxter_dynamics_interfaces'}
    for (value,) in (manifest(REPOSITORY, 'license'), manifest(REPOSITORY, 'maintainer')):
        assert f"'{value}'" in texts['setup.py']
    assert manifest(REPOSITORY, 'license') == manifest(INTERFACES, 'license')


def test_interface_types_are_declared():
    files = sorted(INTERFACES.glob('srv/*.srv')) + sorted(INTERFACES.glob('action/*.action'))
    used = {package for file in files for package in
            re.findall(r'^(\w+)/\w+', file.read_text('utf-8'), re.MULTILINE)}
    assert used and used <= manifest(INTERFACES, 'depend')
    cmake = (INTERFACES / 'CMakeLists.txt').read_text('utf-8')
    assert used <= set(re.findall(r'find_package\((\w+) REQUIRED\)', cmake))
    assert set(re.findall(r'\w+/\w+\.(?:srv|action)', cmake)) == {
        f'{file.parent.name}/{file.name}' for file in files}


def test_console_scripts_name_functions():
    assert len(SCRIPTS) == 4
    for _, module, function in SCRIPTS:
        assert callable(getattr(importlib.import_module(module), function)), function


@pytest.fixture(scope='module')
def topics():
    """Return the module with the names of topics."""
    return pytest.importorskip(f'{NAME}.nodes.topics', reason='needs ROS 2')


@pytest.fixture(scope='module')
def published(topics):
    """Return the topics that layouts may show; the efforts last."""
    node = (topics.EXTERNAL_WRENCH, topics.CONTACT, topics.PREDICTED_EFFORT,
            topics.EFFORT_RESIDUAL, topics.EXTERNAL_EFFORT)
    return [topics.DIAGNOSTICS, *(NODE + name for name in node), topics.JOINT_STATES]


@pytest.mark.parametrize('path', LAUNCH, ids=lambda path: path.name)
def test_names_in_launch_files_exist(path, topics):
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


def test_plotjuggler_plots_each_joint_of_existing_topics(published):
    root = ET.parse(REPOSITORY / 'config' / 'plotjuggler.xml').getroot()
    subscribed = set(root.find('.//selected_topics').get('value').split(';'))
    names = [curve.get('name') for curve in root.iter('curve')]
    assert subscribed <= set(published)
    assert all(any(name.startswith(topic + '/') for topic in subscribed) for name in names)
    for topic in published[-4:]:
        assert [name for name in names if name.startswith(topic + '/')] == [
            f'{topic}/{joint}/effort' for joint in joint_names('right')]
    # Only header stamps place measured and predicted effort at the same instant.
    assert root.find('.//use_header_stamp').get('value') == 'true'


def test_foxglove_plots_each_joint_of_existing_topics(published):
    """An index is right for the messages of the node only, whose joint order is fixed."""
    layout, plotted = json.loads((REPOSITORY / 'config' / 'foxglove.json').read_text('utf-8')), {}
    for panel in layout['configById'].values():
        paths = [panel[key] for key in ('path', 'topicToRender') if key in panel]
        paths += [path['value'] for path in panel.get('paths', ())]
        assert paths and {path.partition('.')[0] for path in paths} <= set(published)
        for path in panel.get('paths', ()):
            if effort := re.fullmatch(rf'({NODE}\w+)\.effort\[(\d)\]', path['value']):
                plotted.setdefault(effort[1], {})[int(effort[2])] = path['label']
    assert plotted == {topic: dict(enumerate(JOINTS)) for topic in published[-4:-1]}


def test_rviz_shows_existing_topics_in_the_frame_of_the_base(topics):
    yaml = pytest.importorskip('yaml', reason='needs PyYAML: pip install ".[offline]"')
    manager = yaml.safe_load((REPOSITORY / 'config' / 'predicted_effort.rviz').read_text('utf-8'))[
        'Visualization Manager']
    shown = {display['Topic']['Value'] for display in manager['Displays'] if 'Topic' in display}
    assert shown == {NODE + topics.PREDICTED_EFFORT, NODE + topics.EXTERNAL_WRENCH}
    assert manager['Global Options']['Fixed Frame'] == 'base'


def _type(value):
    return [type(item) for item in value] if isinstance(value, (list, tuple)) else type(value)

"""The layouts for PlotJuggler, Foxglove and RViz show what the node publishes, joint by joint."""

import ast
import json
from pathlib import Path
import re
import xml.etree.ElementTree as ET

from baxter_dynamics_ros.model.joints import joint_names, JOINTS
import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
CONFIG = REPOSITORY / 'config'
NODE = '/torque_predictor/'
EFFORTS = ('predicted_effort', 'effort_residual', 'external_effort')


@pytest.fixture(scope='module')
def plotjuggler():
    """Return the root of PlotJuggler's layout."""
    return ET.parse(CONFIG / 'plotjuggler.xml').getroot()


@pytest.fixture(scope='module')
def foxglove():
    """Return Foxglove's layout."""
    return json.loads((CONFIG / 'foxglove.json').read_text('utf-8'))


@pytest.fixture(scope='module')
def rviz():
    """Return RViz's configuration."""
    yaml = pytest.importorskip('yaml', reason='needs PyYAML: pip install ".[offline]"')
    return yaml.safe_load((CONFIG / 'predicted_effort.rviz').read_text('utf-8'))


@pytest.fixture(scope='module')
def published():
    """Return the topics that the node publishes or reads, as nodes/topics.py names them."""
    names = _constants()
    return {names['JOINT_STATES'], names['DIAGNOSTICS'], *(NODE + names[key] for key in (
        'PREDICTED_EFFORT', 'EFFORT_RESIDUAL', 'EXTERNAL_EFFORT', 'EXTERNAL_WRENCH', 'CONTACT'))}


def test_plotjuggler_subscribes_to_what_it_plots(plotjuggler, published):
    plugin, = plotjuggler.iter('plugin')
    assert plugin.get('ID') == plotjuggler.find('previouslyLoaded_Streamer').get('name')
    subscribed = plugin.find('selected_topics').get('value').split(';')
    assert set(subscribed) <= published and len(set(subscribed)) == len(subscribed)
    plotted = {_topic(curve.get('name'), subscribed) for curve in plotjuggler.iter('curve')}
    assert plotted == set(subscribed)
    # Measured and predicted are of the same instant only where the stamps say so.
    assert plugin.find('use_header_stamp').get('value') == 'true'


def test_plotjuggler_plots_each_joint_by_its_name(plotjuggler):
    names = [curve.get('name') for curve in plotjuggler.iter('curve')]
    for topic in ('/robot/joint_states', *(NODE + effort for effort in EFFORTS)):
        assert [name for name in names if name.startswith(topic + '/')] == [
            f'{topic}/{joint}/effort' for joint in joint_names('right')]
    for area in plotjuggler.iter('DockArea'):
        joint, colon, _ = area.get('name').partition(': ')
        if colon:
            assert all(f'/right_{joint}/' in curve.get('name') for curve in area.iter('curve'))


def test_plotjuggler_has_as_many_parts_as_it_says(plotjuggler):
    for splitter in plotjuggler.iter('DockSplitter'):
        count = int(splitter.get('count'))
        assert count == len(splitter) == len(splitter.get('sizes').split(';'))
    assert [tab.get('tab_name') for tab in plotjuggler.iter('Tab')] == [
        'measured and predicted', 'residual', 'external effort', 'contact and wrench']


def test_foxglove_shows_topics_that_are_there(foxglove, published):
    for panel in foxglove['configById'].values():
        paths = [panel[key] for key in ('path', 'topicToRender') if key in panel]
        paths += [path['value'] for path in panel.get('paths', ())]
        assert paths and {path.partition('.')[0] for path in paths} <= published


def test_foxglove_labels_each_index_with_its_joint(foxglove):
    """The index is right for the node's messages, which have the joints in the package's order."""
    plotted = {}
    for panel in foxglove['configById'].values():
        for path in panel.get('paths', ()):
            effort = re.fullmatch(rf'{NODE}(\w+)\.effort\[(\d)\]', path['value'])
            if effort:
                plotted.setdefault(effort[1], {})[int(effort[2])] = path['label']
            assert '/robot/joint_states' not in path['value']  # in the robot's own order
    assert plotted == {topic: dict(enumerate(JOINTS)) for topic in EFFORTS}


def test_foxglove_places_each_panel_once(foxglove):
    def panels(part):
        return [part] if isinstance(part, str) else panels(part['first']) + panels(part['second'])
    assert sorted(panels(foxglove['layout'])) == sorted(foxglove['configById'])
    contact, = (panel for name, panel in foxglove['configById'].items() if 'rules' in panel)
    assert {rule['rawValue'] for rule in contact['rules']} == {'true', 'false'}


def test_rviz_shows_the_predicted_effort_in_the_frame_of_the_base(rviz, published):
    manager = rviz['Visualization Manager']
    shown = {display['Class'].split('/')[1]: display for display in manager['Displays']}
    assert shown.keys() == {'Grid', 'RobotModel', 'TF', 'Effort'}
    assert shown['Effort']['Topic']['Value'] == NODE + 'predicted_effort'
    assert shown['Effort']['Topic']['Value'] in published
    assert (shown['Effort']['Robot Description']
            == shown['RobotModel']['Description Topic']['Value'] == '/robot_description')
    assert manager['Global Options']['Fixed Frame'] == 'base'


def test_the_page_names_files_that_are_there():
    page = (REPOSITORY / 'docs' / 'watch.md').read_text('utf-8')
    named = set(re.findall(r'\bconfig/([\w.]+)', page))
    assert {'plotjuggler.xml', 'foxglove.json', 'predicted_effort.rviz'} <= named
    assert all((CONFIG / name).is_file() for name in named)


def _topic(name, topics):
    """Return the topic that a series is of; itself where it is of none."""
    return next((topic for topic in topics if name.startswith(topic + '/')), name)


def _constants():
    """Return the strings in nodes/topics.py, without importing ROS."""
    topics = REPOSITORY / 'baxter_dynamics_ros' / 'nodes' / 'topics.py'
    tree = ast.parse(topics.read_text('utf-8'))
    return {node.targets[0].id: node.value.value for node in tree.body
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)}

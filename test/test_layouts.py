"""The layouts for PlotJuggler, Foxglove and RViz show existing topics, joint by joint."""

import json
from pathlib import Path
import re
import xml.etree.ElementTree as ET

from baxter_dynamics_ros.model.joints import joint_names, JOINTS
import pytest

topics = pytest.importorskip('baxter_dynamics_ros.nodes.topics', reason='needs ROS 2')

CONFIG = Path(__file__).resolve().parents[1] / 'config'
NODE = '/torque_predictor/'
EFFORTS = (topics.PREDICTED_EFFORT, topics.EFFORT_RESIDUAL, topics.EXTERNAL_EFFORT)
PUBLISHED = {topics.JOINT_STATES, topics.DIAGNOSTICS, *(NODE + name for name in (
    *EFFORTS, topics.EXTERNAL_WRENCH, topics.CONTACT))}


def test_plotjuggler_plots_each_joint_of_existing_topics():
    root = ET.parse(CONFIG / 'plotjuggler.xml').getroot()
    subscribed = set(root.find('.//selected_topics').get('value').split(';'))
    names = [curve.get('name') for curve in root.iter('curve')]
    assert subscribed <= PUBLISHED
    assert all(any(name.startswith(topic + '/') for topic in subscribed) for name in names)
    for topic in (topics.JOINT_STATES, *(NODE + effort for effort in EFFORTS)):
        assert [name for name in names if name.startswith(topic + '/')] == [
            f'{topic}/{joint}/effort' for joint in joint_names('right')]
    # Only header stamps place measured and predicted effort at the same instant.
    assert root.find('.//use_header_stamp').get('value') == 'true'


def test_foxglove_plots_each_joint_of_existing_topics():
    """An index is right for the messages of the node only, whose joint order is fixed."""
    layout, plotted = json.loads((CONFIG / 'foxglove.json').read_text('utf-8')), {}
    for panel in layout['configById'].values():
        paths = [panel[key] for key in ('path', 'topicToRender') if key in panel]
        paths += [path['value'] for path in panel.get('paths', ())]
        assert paths and {path.partition('.')[0] for path in paths} <= PUBLISHED
        for path in panel.get('paths', ()):
            if effort := re.fullmatch(rf'{NODE}(\w+)\.effort\[(\d)\]', path['value']):
                plotted.setdefault(effort[1], {})[int(effort[2])] = path['label']
    assert plotted == {topic: dict(enumerate(JOINTS)) for topic in EFFORTS}


def test_rviz_shows_existing_topics_in_the_frame_of_the_base():
    yaml = pytest.importorskip('yaml', reason='needs PyYAML: pip install ".[offline]"')
    manager = yaml.safe_load((CONFIG / 'predicted_effort.rviz').read_text('utf-8'))[
        'Visualization Manager']
    shown = {display['Topic']['Value'] for display in manager['Displays'] if 'Topic' in display}
    assert shown == {NODE + topics.PREDICTED_EFFORT, NODE + topics.EXTERNAL_WRENCH}
    assert manager['Global Options']['Fixed Frame'] == 'base'

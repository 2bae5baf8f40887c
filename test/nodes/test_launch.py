"""The launch file of the predictor: which node it starts with which argument."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

LAUNCH = Path(__file__).parents[2] / 'launch'


@pytest.fixture(scope='module')
def root():
    """Return the root of the predictor's launch file."""
    return ElementTree.parse(LAUNCH / 'torque_predictor.launch.xml').getroot()


def arguments(root):
    """Return the arguments of a launch file: name to default."""
    return {each.get('name'): each.get('default') for each in root.findall('arg')}


def test_the_parameter_file_names_the_arm_unless_an_argument_does(root):
    assert arguments(root)['arm'] == 'as_in_params'
    silent, given = root.findall('node[@exec="torque_predictor"]')
    assert silent.get('if') == '$(equals $(var arm) as_in_params)'
    assert given.get('if') == '$(or $(equals $(var arm) right) $(equals $(var arm) left))'
    assert silent.findall('param[@name]') == []
    # The last of a parameter's values holds.
    assert [each.attrib for each in given.findall('param')] == [
        {'from': '$(var params)'}, {'name': 'arm', 'value': '$(var arm)'}]
    for node in (silent, given):
        assert (node.get('name'), node.get('namespace')) == (
            'torque_predictor', '$(var namespace)')


def test_both_arms_are_two_nodes_in_namespaces_of_their_own(root):
    (group,) = root.findall('group')
    assert group.get('if') == '$(equals $(var arm) both)'
    for node, arm in zip(group.findall('node'), ('right', 'left'), strict=True):
        assert (node.get('name'), node.get('namespace')) == (
            'torque_predictor', f'$(var namespace)/{arm}')
        assert [each.attrib for each in node.findall('param')] == [
            {'from': f'$(var {arm}_params)'}, {'name': 'arm', 'value': arm}]
        assert arguments(root)[f'{arm}_params'] == '$(var params)'


def test_a_simulated_robot_has_its_own_parameters_and_time(root):
    simulated, real = root.findall('arg[@name="params"]')  # the first that applies holds
    assert simulated.get('if') == '$(var simulation)'
    assert simulated.get('default').endswith('/config/simulation.yaml')
    assert real.get('default').endswith('/config/right_arm.yaml')
    (time,) = root.findall('set_parameter')
    assert time.attrib == {
        'name': 'use_sim_time', 'value': 'true', 'if': '$(var simulation)'}


def test_a_robot_is_bridged_if_it_is_named(root):
    (bridge,) = root.findall('node[@exec="joint_state_bridge"]')
    assert bridge.get('unless') == '$(eval "\'$(var robot)\' == \'\'")'
    assert arguments(root)['robot'] == ''
    assert [each.attrib for each in bridge.findall('param')] == [
        {'name': 'master_uri', 'value': '$(var robot)'}]


def test_every_node_takes_joint_states_from_the_topic_given(root):
    for node in root.iter('node'):
        assert [each.attrib for each in node.findall('remap')] == [
            {'from': '/robot/joint_states', 'to': '$(var joint_states)'}]


@pytest.mark.parametrize('file, choices', [
    ('torque_predictor', ['as_in_params', 'right', 'left', 'both']), ('demo', ['right', 'left'])])
def test_a_misspelt_arm_is_refused_by_name(file, choices):
    """As launch does where an argument has choices; arguments that do not exist, it ignores."""
    root = ElementTree.parse(LAUNCH / f'{file}.launch.xml').getroot()
    (arm,) = root.findall('arg[@name="arm"]')
    assert [each.get('value') for each in arm.findall('choice')] == choices
    assert arm.get('default') in choices

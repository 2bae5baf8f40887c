"""Launch files: which node starts with which argument."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

LAUNCH = Path(__file__).parents[2] / 'launch'
BOTH = '$(equals $(var arm) both)'
# Condition -> arm, namespace and parameters of each predictor. The last value of a parameter
# holds, so the arm of the parameter file holds unless an argument names it.
PREDICTORS = {
    '$(equals $(var arm) as_in_params)': [('$(var namespace)', [{'from': '$(var params)'}])],
    '$(or $(equals $(var arm) right) $(equals $(var arm) left))': [
        ('$(var namespace)', [{'from': '$(var params)'}, {'name': 'arm', 'value': '$(var arm)'}])],
    BOTH: [(f'$(var namespace)/{arm}',
            [{'from': f'$(var {arm}_params)'}, {'name': 'arm', 'value': arm}])
           for arm in ('right', 'left')],
}


@pytest.fixture(scope='module')
def root():
    """Return the root of the predictor's launch file."""
    return ElementTree.parse(LAUNCH / 'torque_predictor.launch.xml').getroot()


def test_predictors_and_their_parameters(root):
    found = {}
    for parent in (root, *root.findall('group')):
        for node in parent.findall('node[@exec="torque_predictor"]'):
            found.setdefault(node.get('if', parent.get('if')), []).append(
                (node.get('namespace'), [each.attrib for each in node.findall('param')]))
            assert node.get('name') == 'torque_predictor'
    assert found == PREDICTORS
    for node in root.iter('node'):
        assert [each.attrib for each in node.findall('remap')] == [
            {'from': '/robot/joint_states', 'to': '$(var joint_states)'}]


def test_arguments(root):
    defaults = {each.get('name'): each.get('default') for each in root.findall('arg')}
    assert defaults['arm'] == 'as_in_params' and defaults['robot'] == ''
    assert defaults['right_params'] == defaults['left_params'] == '$(var params)'
    simulated, real = root.findall('arg[@name="params"]')  # the first that applies holds
    assert simulated.get('if') == '$(var simulation)'
    assert simulated.get('default').endswith('/config/simulation.yaml')
    assert real.get('default').endswith('/config/right_arm.yaml')
    (time,) = root.findall('set_parameter')
    assert time.attrib == {'name': 'use_sim_time', 'value': 'true', 'if': '$(var simulation)'}
    (bridge,) = root.findall('node[@exec="joint_state_bridge"]')
    assert bridge.get('unless') == '$(eval "\'$(var robot)\' == \'\'")'
    assert [each.attrib for each in bridge.findall('param')] == [
        {'name': 'master_uri', 'value': '$(var robot)'}]


@pytest.mark.parametrize('file, choices', [
    ('torque_predictor', ['as_in_params', 'right', 'left', 'both']), ('demo', ['right', 'left'])])
def test_choices_of_the_arm(file, choices):
    """Launch refuses other values by name."""
    root = ElementTree.parse(LAUNCH / f'{file}.launch.xml').getroot()
    (arm,) = root.findall('arg[@name="arm"]')
    assert [each.get('value') for each in arm.findall('choice')] == choices
    assert arm.get('default') in choices

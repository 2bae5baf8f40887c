"""The SROS2 policy allows everything that the running nodes do, and nothing else."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

POLICY = Path(__file__).parents[2] / 'config' / 'sros2_policy.xml'
PERMISSIONS = {'topics': ('publish', 'subscribe'), 'services': ('reply', 'request'),
               'actions': ('execute', 'call')}
# Topics and services of an action: for the permission of its server, and of its client.
ACTION_TOPICS = ('feedback', 'status')
ACTION_SERVICES = ('cancel_goal', 'get_result', 'send_goal')
# Parameters with which each node uses all that it may use.
RUNS = {'torque_predictor': ['-p', 'use_sim_time:=true'], 'fake_baxter': []}


@pytest.fixture(scope='module')
def allowed():
    """Return a function from an enclave to what it allows: permission to names, in full."""
    policy = ElementTree.parse(POLICY).getroot()

    def allowed_(enclave):
        (profile,) = policy.findall(f'enclaves/enclave[@path="/{enclave}"]/profiles/profile')
        own = profile.get('ns').rstrip('/') + '/' + profile.get('node')
        names = {kind: [] for kinds in PERMISSIONS.values() for kind in kinds}
        for block in profile.findall('*'):
            for kind in block.attrib:
                names[kind] += [each.text.replace('~', own, 1) for each in block.findall('*')]
        for role, topic, service in (('execute', 'publish', 'reply'),
                                     ('call', 'subscribe', 'request')):
            for action in names.pop(role):
                names[topic] += [f'{action}/_action/{each}' for each in ACTION_TOPICS]
                names[service] += [f'{action}/_action/{each}' for each in ACTION_SERVICES]
        assert all(len(each) == len(set(each)) for each in names.values())
        return {kind: set(each) for kind, each in names.items()}
    return allowed_


def used(robot, name, namespace):
    """Return what a running node does: permission to names, in full, as if in no namespace."""
    return {kind: {each.removeprefix(namespace) for each, _ in ask(name, namespace)}
            for kind, ask in (('publish', robot.get_publisher_names_and_types_by_node),
                              ('subscribe', robot.get_subscriber_names_and_types_by_node),
                              ('reply', robot.get_service_names_and_types_by_node),
                              ('request', robot.get_client_names_and_types_by_node))}


def test_allows_exactly_what_the_nodes_do(robot, start, allowed):
    pytest.importorskip('mujoco', reason='needs pip install ".[demo]"')
    pytest.importorskip('baxter_dynamics_interfaces.srv',
                        reason='needs pip install ./baxter_dynamics_interfaces')
    processes = [start(executable, '-r', '__ns:=/run', *arguments)
                 for executable, arguments in RUNS.items()]
    robot.until(lambda: all('[INFO]' in process.output for process in processes) and {
        (executable, '/run') for executable in RUNS} <= {*robot.get_node_names_and_namespaces()})
    for executable in RUNS:
        robot.until(lambda: used(robot, executable, '/run') == allowed(executable))
    robot.spin(0.7)  # what is discovered arrives in parts
    for executable in RUNS:
        assert used(robot, executable, '/run') == allowed(executable)


def test_an_operator_may_use_the_whole_predictor_and_command_no_robot(allowed):
    operator, predictor = allowed('operator'), allowed('torque_predictor')
    common = {'/parameter_events', '/rosout'}
    assert operator['subscribe'] == predictor['publish'] - common
    assert operator['request'] == predictor['reply'] - {'/torque_predictor/get_type_description'}
    assert operator['publish'] == common
    own = {name.replace('/torque_predictor/', '/operator/') for name in predictor['reply']
           if 'parameter' in name or 'description' in name}
    assert operator['reply'] == own | {'/_ros2cli_*/get_type_description'}

"""The SROS2 policy allows everything that the running nodes do, and nothing else."""

from pathlib import Path
from xml.etree import ElementTree

import pytest

POLICY = Path(__file__).parents[2] / 'config' / 'sros2_policy.xml'
CHILDREN = {'policy': {'enclaves'}, 'enclaves': {'enclave'}, 'enclave': {'profiles'},
            'profiles': {'profile'}, 'profile': {'topics', 'services', 'actions'},
            'topics': {'topic'}, 'services': {'service'}, 'actions': {'action'},
            'topic': set(), 'service': set(), 'action': set()}
ATTRIBUTES = {'policy': {'version'}, 'enclave': {'path'}, 'profile': {'ns', 'node'}}
PERMISSIONS = {'topics': ('publish', 'subscribe'), 'services': ('reply', 'request'),
               'actions': ('execute', 'call')}
# Topics and services of an action: for the permission of its server, and of its client.
ACTION_TOPICS = ('feedback', 'status')
ACTION_SERVICES = ('cancel_goal', 'get_result', 'send_goal')
# Parameters with which each node uses all that it may use.
RUNS = {'torque_predictor': ['-p', 'use_sim_time:=true'], 'fake_baxter': []}


@pytest.fixture(scope='module')
def policy():
    """Return the policy's root, with its comments."""
    builder = ElementTree.TreeBuilder(insert_comments=True)
    return ElementTree.parse(POLICY, ElementTree.XMLParser(target=builder)).getroot()


@pytest.fixture(scope='module')
def allowed(policy):
    """Return a function from an enclave to what it allows: permission to names, in full."""
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


def test_has_the_format_of_sros2(policy):
    assert policy.attrib == {'version': '0.2.0'}
    for element in policy.iter():
        if element.tag is ElementTree.Comment:
            continue
        children = {child.tag for child in element} - {ElementTree.Comment}
        assert children <= CHILDREN[element.tag]
        assert bool(children) == bool(CHILDREN[element.tag])
        if element.tag in PERMISSIONS:
            (permission,) = element.attrib
            assert permission in PERMISSIONS[element.tag]
            assert element.get(permission) == 'ALLOW'
        else:
            assert set(element.attrib) == ATTRIBUTES.get(element.tag, set())
        if element.tag in ('topic', 'service', 'action'):
            assert element.text.startswith(('/', '~/')) and element.text == element.text.strip()
    # `ros2 security generate_artifacts` takes a comment there for an enclave.
    assert ElementTree.Comment not in [child.tag for child in policy.find('enclaves')]


@pytest.mark.parametrize('executable', RUNS)
def test_allows_exactly_what_the_node_does(robot, start, allowed, executable):
    if executable == 'fake_baxter':
        pytest.importorskip('mujoco', reason='needs pip install ".[demo]"')
    else:
        pytest.importorskip('baxter_dynamics_interfaces.srv',
                            reason='needs pip install ./baxter_dynamics_interfaces')
    process = start(executable, '-r', '__ns:=/run', *RUNS[executable])
    robot.until(lambda: '[INFO]' in process.output and (executable, '/run') in
                robot.get_node_names_and_namespaces())
    robot.until(lambda: used(robot, executable, '/run') == allowed(executable))
    robot.spin(0.7)  # what is discovered arrives in parts
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

"""The node and the commands read parameter files alike."""

import json
from pathlib import Path
import subprocess
import sys

from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings
from baxter_dynamics_ros.model.exceptions import BaxterDynamicsError
import pytest

pytest.importorskip('yaml', reason='parameter files need PyYAML: pip install pyyaml')
from baxter_dynamics_ros.recordings.parameter_file import read_parameters  # noqa: E402, I100

WILD, OWN, OTHER = '/**:\n', 'torque_predictor:\n', '/robot1/torque_predictor:\n'


def under(node, *lines):
    """Return a file with parameters of a node."""
    return node + '  ros__parameters:\n' + ''.join(f'    {line}\n' for line in lines)


MASS = {value: under(WILD, f'payload.mass: {value}') for value in (
    '0.3', '3e-1', '1', '1_0.0', '.5', '+0.5', '2.', '"0.3"', '!!str 0.3', '!!float abc',
    '&anchor 0.3', '2001-01-01', 'null', '.nan', 'inf', '1e400', '9' * 5000, '012', '[0.3]', '[]',
    '12:30', '', '! 0.3', '>-\n      0.3', '|\n      0.3')}
BOOLEAN = {value: under(WILD, f'effort_model: {{enabled: {value}}}') for value in (
    'n', 'Off', 'NO', 'y', 'nO', '0', "'true'")}
GRAVITY = {value: under(WILD, f'gravity: {value}') for value in (
    '[0.0, 1e-3, -9.81]', '[0, 0, -9.81]', '[0, 0, -10]', '[0.0, 0.0]', '[[0.0], [0.0]]',
    '[0.0, -0.0, on]')}
NODES = {
    'other namespaces': under(OTHER, 'payload.mass: 0.3') + under(
        '/robot2/torque_predictor:\n', 'payload.mass: 0.9'),
    'nested namespace': '/robot1:\n  torque_predictor:\n    ros__parameters: {payload.mass: 0.3}',
    'trailing slash': '/robot1/:\n  torque_predictor:\n    ros__parameters: {payload.mass: 0.3}',
    'wildcard below a namespace': under('/robot1/**:\n', 'payload.mass: 0.3'),
    'one level': under('/*:\n', 'payload.mass: 0.3'),
    'any namespace': under('/**/torque_predictor:\n', 'payload.mass: 0.3'),
    'order': under(OWN, 'payload.mass: 0.1') + under(WILD, 'payload.mass: 0.2')
    + under('/torque_predictor:\n', 'arm: left'),
    'documents': under(WILD, 'payload: {mass: 0.3}') + '---\n' + under(
        WILD, 'payload: {mass: 0.4}'),
    'twice, by two ways': under(WILD, 'payload.mass: 0.3', 'payload: {mass: 0.4}'),
    'twice, of two types': under(WILD, 'payload.mass: 1', 'payload.mass: 0.4'),
    'alias': under(WILD, 'payload.mass: &m 0.3', 'acceleration.velocity_lag: *m'),
    'merged mapping': 'a: &a {x: 1.0}\n/**:\n  ros__parameters: {<<: *a}',
    'bad name': under('/robot-1/torque_predictor:\n', 'payload.mass: 0.3'),
    'no name': 'ros__parameters:\n  payload.mass: 0.3', 'no parameters': WILD + '  x: 1',
    'not YAML': WILD + '\tros__parameters: {}', 'not text': '\udcff', 'empty': '',
    'list': '- 1', 'empty parameters': WILD + '  ros__parameters: {}',
    'empty group': under(WILD, 'payload: {}', 'arm: left'),
    'of every node': under(WILD, 'use_sim_time: true', 'start_type_description_service: true',
                           'publish_rate: 50.0', 'arm: left'),
    'of every node, wrong': under(WILD, 'use_sim_time: 1'),
    'misspelt': under(WILD, 'payload.mas: 0.3'),
    'out of range': under(WILD, 'payload.mass: 11.0'),
    'impossible': under(WILD, 'payload: {inertia: [0.1, 0.1, 0.1, 0.0, 0.0, 0.0]}'),
    'choice': under(WILD, 'arm: middle'), 'integer': under(WILD, 'contact.samples: 3'),
    'not an integer': under(WILD, 'contact.samples: 3.0'),
}
SHIPPED = sorted((Path(__file__).parents[2] / 'config').glob('*.yaml'))
FILES = [*MASS.values(), *BOOLEAN.values(), *GRAVITY.values(), *NODES.values(),
         *(path.read_text() for path in SHIPPED)]
# Files given together, in order.
PAIRS = [(MASS['0.3'], MASS['.5']), (MASS['.5'], MASS['0.3']), (MASS['1'], MASS['0.3']),
         (NODES['documents'], under(WILD, 'payload: {mass: 1}')),
         (under(OWN, 'payload.mass: 0.1'), MASS['0.3']), (NODES['list'], MASS['0.3'])]

# The parameters of the real node, declared with each list of files in turn.
CHILD = """
import gc, json, os, sys
from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings, SETTINGS
from baxter_dynamics_ros.nodes.ros_parameters import ParameterNode
import rclpy

class Declaring(ParameterNode):
    def build(self, values):
        return PredictorSettings.from_parameters(values)

def declared(arguments):
    rclpy.init(args=['--ros-args', *arguments])
    node = Declaring('torque_predictor')
    try:
        node.declare_settings(SETTINGS)
        node.check_given_names()
        return {name: node.get_parameter(name).value for name in DEFAULTS}
    finally:
        node.destroy_node()

out = os.fdopen(os.dup(1), 'w')
os.dup2(2, 1)
for files, namespace in json.load(sys.stdin):
    try:
        result = declared(['-r', f'__ns:={namespace}', *(
            each for file in files for each in ('--params-file', file))])
    except Exception as error:
        result = str(error)
        gc.collect()  # Fast DDS may deadlock when it destroys one participant beside another
    rclpy.try_shutdown()
    print(json.dumps(result, default=list), file=out, flush=True)
"""


def _by_node(cases):
    """Return the settings of the node for each case, or why it refuses to start."""
    answer = subprocess.run([sys.executable, '-c', CHILD], input=json.dumps(cases), text=True,
                            capture_output=True)
    assert answer.returncode == 0, answer.stderr[-2000:]
    return [json.loads(line) for line in answer.stdout.splitlines()]


def _by_reader(files, namespace):
    try:
        values = read_parameters(files, f'{namespace.rstrip("/")}/torque_predictor')
    except BaxterDynamicsError as error:
        assert '\n' not in str(error)
        return str(error)
    return {name: list(value) if isinstance(value, tuple) else value
            for name, value in PredictorSettings.from_parameters(values).parameters().items()}


def test_values_and_refusals_agree(domain, tmp_path):
    cases = []
    for i, texts in enumerate([(text,) for text in FILES] + PAIRS):
        files = []
        for k, text in enumerate(texts):
            path = tmp_path / f'{i}_{k}.yaml'
            path.write_bytes(text.encode(errors='surrogateescape'))
            files.append(str(path))
        cases += [(files, namespace) for namespace in (
            ('/', '/robot1') if 'robot' in ''.join(texts) else ('/',))]
    found = _by_node(cases)
    assert len(found) == len(cases) > 60
    refused = 0
    for (files, namespace), node in zip(cases, found):
        reader = _by_reader(files, namespace)
        case = f'{open(files[-1], "rb").read()} in {namespace}\nnode: {node}\nreader: {reader}'
        if isinstance(node, str):
            refused += 1
            assert isinstance(reader, str), case
        else:
            assert reader == node, case
    assert 20 < refused < len(cases) - 20
    assert set(DEFAULTS) == set(next(each for each in found if isinstance(each, dict)))

"""The documents say what the code does: parameters, events, topics, commands."""

import ast
from pathlib import Path
import re

from baxter_dynamics_ros.estimation.events import Event, REMEDIES
from baxter_dynamics_ros.estimation.settings import SETTINGS
from baxter_dynamics_ros.model import paper_tables
import numpy as np
import pytest

REPOSITORY = Path(__file__).parents[1]
NODE = (REPOSITORY / 'docs' / 'node.md').read_text(encoding='utf-8')
README = (REPOSITORY / 'README.md').read_text(encoding='utf-8')


def rows(text):
    """Return the cells of all table rows, with the first cell's backticks taken off."""
    result = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in re.split(r'(?<!\\)\|', line)[1:-1]]
        if cells:
            result[cells[0].strip('`')] = cells
    return result


@pytest.mark.parametrize('setting', SETTINGS, ids=lambda setting: setting.name)
def test_each_parameter_is_documented_as_it_is(setting):
    _, default, unit, limits, text = rows(NODE.split('## What it does')[0])[setting.name]
    assert text
    assert unit.replace('²', '^2') == setting.unit
    value = default.strip('`').replace('−', '-')
    if value.startswith('Table '):
        table = np.array(getattr(paper_tables, value.upper().replace(' ', '_')))
        column = table[:, -1] if setting.name == 'links.mass' else table.ravel()
        assert setting.default == tuple(column)
    elif isinstance(setting.default, tuple):
        zeros = re.fullmatch(r'0 \((\d)\)', value)
        numbers = [0.0] * int(zeros[1]) if zeros else [float(x) for x in value.split()]
        assert tuple(numbers) == setting.default
    elif isinstance(setting.default, float):
        assert float(value) == setting.default
    else:
        assert value == str(setting.default).replace('True', 'true')
    if setting.choices:
        assert limits == ', '.join(f'`{choice}`' for choice in setting.choices)
    elif limits.startswith('±'):
        assert float(limits[1:]) == setting.upper == -setting.lower
    elif limits:
        assert [float(x) for x in limits.split('…')] == [setting.lower, setting.upper]


@pytest.mark.parametrize('event', Event, ids=lambda event: event.value)
def test_each_event_is_documented(event):
    assert f'`{event.value}`' in NODE


def test_each_message_of_the_diagnostics_is_explained():
    diagnostics = pytest.importorskip(
        'baxter_dynamics_ros.nodes.diagnostics', reason='needs ROS 2')
    explained = rows(NODE.split('## Diagnostics')[1])
    for message in (*diagnostics.SAYS.values(), *REMEDIES.values()):
        message = re.sub(r'^; ', '…; ', re.sub(r'\{[^}]*\}', '…', message))
        assert message in explained, message
    said = set(map(len, explained.values()))
    assert said == {2, 4}  # keys of a status; message, level, cause, remedy


def test_no_parameter_or_event_is_documented_that_is_not_there():
    table = NODE.split('## What it does')[0]
    documented = set(re.findall(r'^\| `([a-z_.]+)` \|', table, re.MULTILINE))
    assert documented == {setting.name for setting in SETTINGS}
    counted = set(re.findall(r'\| `([a-z_]+)` \|$', NODE, re.MULTILINE))
    assert counted == {event.value for event in Event}


def test_readme_names_every_topic_and_service():
    topics = pytest.importorskip('baxter_dynamics_ros.nodes.topics', reason='needs ROS 2')
    for name in (topics.JOINT_STATES, topics.DIAGNOSTICS, topics.RESET, *map(topics.below_node, (
            topics.PREDICTED_EFFORT, topics.EFFORT_RESIDUAL, topics.EXTERNAL_EFFORT,
            topics.EXTERNAL_WRENCH, topics.CONTACT, topics.GRAVITY_TORQUES,
            topics.INVERSE_DYNAMICS))):
        assert f'`{name}`' in README


def test_readme_example_runs():
    code = re.search(r'```python\n(.*?)```', README, re.DOTALL)[1]
    names = {}
    exec(code, names)
    assert names['tau'].shape == (7,)


def test_what_troubleshooting_quotes_is_what_is_said():
    said = ' '.join(node.value for path in (REPOSITORY / 'baxter_dynamics_ros').rglob('*.py')
                    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8')))
                    if isinstance(node, ast.Constant) and isinstance(node.value, str))
    page = (REPOSITORY / 'docs' / 'troubleshooting.md').read_text(encoding='utf-8')
    quoted = {text for line in page.splitlines() if line.startswith('| ')
              for text in re.findall(r'`([^`]+)`', line.split(' | ')[0])
              if len(text.split()) > 2 and not text.startswith(('ros2 ', 'payload.'))}
    assert len(quoted) > 5
    for text in quoted:
        for piece in text.split('…'):  # names, which stand in braces in the code
            assert piece.strip(' :') in said, text


def test_links_lead_somewhere():
    for file in [REPOSITORY / 'README.md', *(REPOSITORY / 'docs').glob('*.md')]:
        for target in re.findall(r'\]\(([^)#]+)\)', file.read_text(encoding='utf-8')):
            assert target.startswith('http') or (file.parent / target).exists(), (file, target)


def test_continuous_integration_runs_the_readmes_test_command():
    commands = re.findall(r'^python3 -m venv .*$', README, re.MULTILINE)
    assert len(commands) == 2
    assert commands[0].endswith('.venv/bin/baxter_dynamics demo')
    assert commands[1].endswith('.venv/bin/pytest -n 3 --dist loadfile')
    assert 'README.md' in (REPOSITORY / '.ci' / 'run').read_text(encoding='utf-8')

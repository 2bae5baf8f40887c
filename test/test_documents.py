"""The documentation agrees with the code: commands, Python blocks, links, parameters, names."""

import ast
import importlib
import inspect
import json
from pathlib import Path
import re
import xml.etree.ElementTree as ET

import baxter_dynamics_ros
from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.estimation.events import Event
from baxter_dynamics_ros.estimation.settings import SETTINGS
import pytest

for module in ('rclpy', 'mujoco', 'rosbags', 'rich', 'casadi', 'scipy', 'yaml'):
    pytest.importorskip(module, reason=f'needs {module}: pip install ".[test]"')

from baxter_dynamics_ros.cli.main import VERBS  # noqa: E402, I100
from baxter_dynamics_ros.nodes import topics  # noqa: E402
from baxter_dynamics_ros.recordings.parameter_file import read_parameters  # noqa: E402
from document_commands import check, Failure  # noqa: E402

REPOSITORY = Path(__file__).resolve().parents[1]
PAGES = {str(path.relative_to(REPOSITORY)): path.read_text(encoding='utf-8')
         for pattern in ('*.md', 'docs/**/*.md') for path in sorted(REPOSITORY.glob(pattern))}
ALL = '\n'.join(PAGES.values())
BLOCK = re.compile(r'^( *)```(\w*)\n(.*?)^\1```', re.MULTILINE | re.DOTALL)
PAGE = pytest.mark.parametrize('page', PAGES)


def blocks(text, *kinds):
    """Return the texts of the fenced blocks of some kinds."""
    return [block for _, kind, block in BLOCK.findall(text) if kind in kinds]


def prose(text):
    """Return a text without its fenced blocks."""
    return BLOCK.sub('', text)


def shell_lines(text):
    """Return the commands of the shell blocks, continuation lines joined, without comments."""
    lines = '\n'.join(blocks(text, 'bash', 'sh')).replace('\\\n', ' ').splitlines()
    return [re.sub(r'\s+#.*', '', line).removeprefix('$ ').strip() for line in lines
            if line.strip() and not line.lstrip().startswith('#')]


def slug(heading):
    """Return the anchor that GitHub gives a heading."""
    plain = re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', heading).lower()
    return re.sub(r'[^\w\- ]', '', plain).strip().replace(' ', '-')


def anchors(text):
    """Return the anchors of a page."""
    return {slug(heading) for heading in re.findall(r'^#+ (.*)$', prose(text), re.MULTILINE)}


def table_rows():
    """Return the cells of all table rows: first cell without backticks, second cell."""
    cells = [[cell.strip() for cell in re.split(r'(?<!\\)\|', line)[1:-1]]
             for line in prose(ALL).splitlines() if line.startswith('| ')]
    return [(row[0].strip('`'), row[1].strip('`')) for row in cells if len(row) > 1]


def number(text):
    """Return a number, also with a typographic minus; None for other text."""
    try:
        return float(text.replace('−', '-'))
    except ValueError:
        return None


@PAGE
def test_commands_are_correct(page):
    wrong = []
    for line in shell_lines(PAGES[page]):
        try:
            check(line)
        except (Failure, baxter_dynamics_ros.BaxterDynamicsError, SyntaxError) as error:
            wrong.append(f'{line}: {error}')
    assert not wrong, '\n'.join(wrong)


@pytest.mark.parametrize('line', [
    'baxter_dynamics evaluat my_bag', 'baxter_dynamics evaluate my_bag --arms right',
    'cd x && baxter_dynamics demo --duration 1', 'rm -r report', "pip install '.[gone]'",
    'pip install ./gone', 'colcon build --base-paths src/baxter_dynamics_ros/gone',
    'python examples/gone.py', 'python benchmarks/model.py --fast',
    'python -m baxter_dynamics_ros.gone', 'pytest test/test_gone.py', 'ros2 sing /robot',
    'ros2 run baxter_dynamics_ros gone', 'torque_predictor -p arm:=left',
    'ros2 topic echo /torque_predictor/gone | head', 'torque_predictor --ros-args -p gone:=1',
    'ros2 launch baxter_dynamics_ros gone.launch.xml',
    'ros2 launch baxter_dynamics_ros torque_predictor.launch.xml gone:=1',
    'FOO=1 ros2 run baxter_dynamics_ros torque_predictor --ros-args -p arm:=head'])
def test_a_wrong_command_is_found(line):
    with pytest.raises((Failure, baxter_dynamics_ros.BaxterDynamicsError)):
        check(line)


@PAGE
def test_python_blocks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks(PAGES[page], 'python'):
        exec(compile(block, page, 'exec'), names)


@PAGE
def test_data_blocks_are_valid(page, tmp_path):
    for block in blocks(PAGES[page], 'json'):
        json.loads(block)
    for block in blocks(PAGES[page], 'xml'):
        ET.fromstring(block)
    for block in blocks(PAGES[page], 'yaml'):
        if 'ros__parameters' in block:
            (tmp_path / 'parameters.yaml').write_text(block)
            read_parameters(tmp_path / 'parameters.yaml')


@PAGE
def test_links_lead_somewhere(page):
    for target in re.findall(r'\]\(([^)\s]+)\)', prose(PAGES[page])):
        if target.startswith(('http://', 'https://', 'mailto:')):
            continue
        path, _, anchor = target.partition('#')
        file = (REPOSITORY / page).parent / path if path else REPOSITORY / page
        assert file.exists(), target
        if anchor and file.suffix == '.md':
            assert anchor in anchors(file.read_text(encoding='utf-8')), target


def test_images_have_a_description_and_every_figure_is_shown():
    images = re.findall(r'!\[([^\]]*)\]\(([^)]+)\)', ALL)
    assert images and all(len(text.split()) >= 4 for text, _ in images)
    assert {path.name for path in (REPOSITORY / 'docs' / 'figures').iterdir()} <= {
        Path(target).name for _, target in images}


@pytest.mark.parametrize('setting', SETTINGS, ids=lambda setting: setting.name)
def test_each_parameter_is_documented_with_its_default(setting):
    defaults = [default for name, default in table_rows() if name == setting.name]
    assert defaults
    if isinstance(setting.default, (bool, str)):
        assert str(setting.default).replace('True', 'true').replace('False', 'false') in defaults
    elif isinstance(setting.default, (int, float)):
        assert setting.default in map(number, defaults)


def test_no_parameter_is_documented_that_does_not_exist():
    groups = {setting.name.partition('.')[0] for setting in SETTINGS if '.' in setting.name}
    documented = {name for name, _ in table_rows() if re.fullmatch(r'[a-z_]+\.[a-z_]+', name)
                  and name.partition('.')[0] in groups}
    assert documented <= {setting.name for setting in SETTINGS}


def test_events_are_documented():
    for event in Event:
        assert f'`{event.value}`' in ALL, event


def test_topics_services_and_commands_are_documented():
    for name in (value for key, value in vars(topics).items()
                 if key.isupper() and isinstance(value, str)):
        assert re.search(rf'`[^`\n]*{re.escape(name)}`', ALL), name
    for verb in VERBS:
        assert f'baxter_dynamics {verb}' in ALL, verb


def test_the_public_interface_is_documented():
    page = PAGES['docs/api.md']
    for name in baxter_dynamics_ros.__all__:
        assert re.search(rf'`[^`\n]*\b{name}\b', page), name
    for name, method in inspect.getmembers(BaxterArm, inspect.isfunction):
        if not name.startswith('_'):
            arguments = ', '.join(list(inspect.signature(method).parameters)[1:])
            assert f'`{name}({arguments})`' in page, name


def test_dotted_names_exist():
    for name in set(re.findall(r'`(baxter_dynamics_ros(?:\.\w+)+)', prose(ALL))):
        module, _, attribute = name.rpartition('.')
        assert (hasattr(importlib.import_module(module), attribute)
                or importlib.util.find_spec(name)), name


def test_files_named_in_backticks_exist():
    for name in set(re.findall(
            r'`((?:docs|test|config|launch|examples|benchmarks|tools)/[\w./-]+\.\w+)`',
            prose(ALL))):
        assert (REPOSITORY / name).exists(), name


def test_quoted_messages_are_those_of_the_code():
    """In the first column of the troubleshooting tables; … stands for what varies."""
    texts = ' '.join(node.value for path in (REPOSITORY / 'baxter_dynamics_ros').rglob('*.py')
                     for node in ast.walk(ast.parse(path.read_text(encoding='utf-8')))
                     if isinstance(node, ast.Constant) and isinstance(node.value, str))
    cells = [line.split(' | ')[0] for line in PAGES['docs/troubleshooting.md'].splitlines()
             if line.startswith('| ')]
    quoted = [text for cell in cells for text in re.findall(r'`([^`]+)`', cell)
              if len(text.split()) > 2 and not text.startswith(('ros2 ', 'payload.'))]
    for text in quoted:
        assert all(piece.strip(' :') in texts for piece in text.split('…')), text


def test_continuous_integration_finds_its_command_in_the_readme():
    assert re.search(r'^python3 -m venv .*pytest', PAGES['README.md'], re.MULTILINE)
    assert 'README.md' in (REPOSITORY / '.ci' / 'run').read_text(encoding='utf-8')

"""The documentation agrees with the code: commands, Python blocks, links, parameters, names."""

import ast
from contextlib import nullcontext
import importlib
import inspect
from pathlib import Path
import re
import shlex
import xml.etree.ElementTree as ET

import baxter_dynamics_ros
from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.estimation.events import Event
from baxter_dynamics_ros.estimation.settings import PredictorSettings, SETTINGS
import pytest

for module in ('rclpy', 'mujoco', 'rosbags', 'rich', 'yaml'):
    pytest.importorskip(module, reason=f'needs {module}: pip install ".[test]"')

from baxter_dynamics_ros.cli.main import parse, VERBS  # noqa: E402, I100
from baxter_dynamics_ros.nodes import topics  # noqa: E402
import yaml  # noqa: E402

REPOSITORY = Path(__file__).resolve().parents[1]
SETUP = (REPOSITORY / 'setup.py').read_text(encoding='utf-8')
PAGES = {str(path.relative_to(REPOSITORY)): path.read_text(encoding='utf-8')
         for pattern in ('*.md', 'docs/**/*.md') for path in sorted(REPOSITORY.glob(pattern))}
ALL = '\n'.join(PAGES.values())
BLOCK = re.compile(r'^( *)```(\w*)\n(.*?)^\1```', re.MULTILINE | re.DOTALL)
PROSE = BLOCK.sub('', ALL)
PAGE = pytest.mark.parametrize('page', PAGES)


def blocks(text, *kinds):
    """Return the texts of the fenced blocks of some kinds."""
    return [block for _, kind, block in BLOCK.findall(text) if kind in kinds]


def shell_lines(text):
    """Return the commands of the shell blocks, continuation lines joined, without comments."""
    lines = '\n'.join(blocks(text, 'bash', 'sh')).replace('\\\n', ' ').splitlines()
    return [re.sub(r'\s+#.*', '', line).removeprefix('$ ').strip() for line in lines
            if line.strip() and not line.lstrip().startswith('#')]


def anchors(text):
    """Return the anchors that GitHub gives the headings of a page."""
    headings = re.findall(r'^#+ (.*)$', BLOCK.sub('', text), re.MULTILINE)
    plain = [re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', heading).lower() for heading in headings]
    return {re.sub(r'[^\w\- ]', '', heading).strip().replace(' ', '-') for heading in plain}


def table_rows():
    """Return the cells of all table rows: first cell without backticks, second cell."""
    cells = [[cell.strip() for cell in re.split(r'(?<!\\)\|', line)[1:-1]]
             for line in PROSE.splitlines() if line.startswith('| ')]
    return [(row[0].strip('`'), row[1].strip('`').replace('−', '-'))
            for row in cells if len(row) > 1]


def commands(line):
    """Yield the words of each command of a shell line."""
    words = shlex.shlex(re.sub(r'\$\([^()]*\)', 'X', line), posix=True, punctuation_chars='&|;')
    words.whitespace_split = True
    command = []
    for word in (*words, '&&'):
        if not re.fullmatch('[&|;]+', word):
            command.append(word)
        else:
            yield [word for word in command if not re.match('[A-Z_]+=', word)]
            command = []


def check(words):
    """Raise an exception if a command or a file of this package is used wrongly."""
    if words[:3:2] == ['ros2', 'baxter_dynamics_ros'] and words[1] == 'run':
        assert f"'{words[3]} = " in SETUP, words[3]
        words = words[3:]
    program, arguments = Path((words or ['.'])[0]).name, words[1:]
    if program == 'baxter_dynamics':
        with pytest.raises(SystemExit, match='^0$') if '--help' in words else nullcontext():
            parse(arguments)
    elif program == 'torque_predictor':
        given = dict(value.split(':=') for flag, value in zip(arguments, arguments[1:])
                     if flag == '-p')
        PredictorSettings.from_parameters({
            name: yaml.safe_load(value) for name, value in given.items()
            if not re.match('use_sim_time|qos_overrides|joint_prefix|frame_id', name)})
    elif words[:3] == ['ros2', 'launch', 'baxter_dynamics_ros']:
        root = ET.parse(REPOSITORY / 'launch' / words[3])
        declared = {argument.get('name') for argument in root.findall('arg')}
        assert {word.partition(':=')[0] for word in words[4:]} <= declared
    for word in words:
        if re.match(r'(\./|\.ci/|benchmarks/|docs/|examples/|test/|tools/)\w', word):
            assert (REPOSITORY / word.partition('::')[0]).exists(), word
        if extras := re.fullmatch(r'\.\[(.*)\]', word):
            assert all(f"'{extra}': " in SETUP for extra in extras[1].split(',')), word
        if name := re.match(r'/(?:\w+/)*(?:torque_predictor|fake_baxter)/(\w+)$', word):
            assert name[1] in vars(topics).values(), word
        if name := re.match(r'baxter_dynamics_interfaces/((srv|action)/.*)', word):
            assert (REPOSITORY / f'{name[0]}.{name[2]}').exists(), word


@PAGE
def test_commands_are_correct(page):
    for line in shell_lines(PAGES[page]):
        for words in commands(line):
            try:
                check(words)
            except (Exception, SystemExit) as error:
                pytest.fail(f'{line}: {error!r}')


@pytest.mark.parametrize('line', [
    'baxter_dynamics evaluat my_bag', 'cd x && baxter_dynamics demo --duration 1',
    "pip install '.[gone]'", 'python examples/gone.py', 'ros2 run baxter_dynamics_ros gone',
    'torque_predictor --ros-args -p gone:=1', 'ros2 topic echo /torque_predictor/gone | head',
    'ros2 launch baxter_dynamics_ros torque_predictor.launch.xml gone:=1',
    'FOO=1 ros2 run baxter_dynamics_ros torque_predictor --ros-args -p arm:=head'])
def test_a_wrong_command_is_found(line):
    with pytest.raises((Exception, SystemExit)):
        for words in commands(line):
            check(words)


@PAGE
def test_python_blocks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks(PAGES[page], 'python'):
        exec(compile(block, page, 'exec'), names)


@PAGE
def test_links_lead_somewhere(page):
    for target in re.findall(r'\]\(([^)\s]+)\)', BLOCK.sub('', PAGES[page])):
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


def test_parameters_are_documented_with_their_defaults():
    rows = table_rows()
    for setting in SETTINGS:
        shown = [default for name, default in rows if name == setting.name]
        assert shown, setting.name
        if not isinstance(setting.default, tuple):
            assert setting.default in [yaml.safe_load(text or "''") for text in shown], setting
    names = {setting.name for setting in SETTINGS}
    groups = {name.partition('.')[0] for name in names if '.' in name}
    documented = {name for name, _ in rows if re.fullmatch(r'[a-z_]+\.[a-z_]+', name)}
    assert {name for name in documented if name.partition('.')[0] in groups} <= names


def test_events_topics_services_and_commands_are_documented():
    names = [value for key, value in vars(topics).items()
             if key.isupper() and isinstance(value, str)]
    for name in (*names, *(event.value for event in Event)):
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


def test_names_and_files_in_backticks_exist():
    for name in set(re.findall(r'`(baxter_dynamics_ros(?:\.\w+)+)', PROSE)):
        module, _, attribute = name.rpartition('.')
        assert (hasattr(importlib.import_module(module), attribute)
                or importlib.util.find_spec(name)), name
    for name in set(re.findall(
            r'`((?:docs|test|config|launch|examples|benchmarks|tools)/[\w./-]+\.\w+)`', PROSE)):
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

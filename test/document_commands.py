"""Checks commands in the documentation: each program's arguments, by its own parser."""

import ast
import importlib.util
from pathlib import Path
import re
import shlex
import xml.etree.ElementTree as ET

from baxter_dynamics_ros.cli.main import parse
from baxter_dynamics_ros.estimation.settings import PredictorSettings
import yaml

REPOSITORY = Path(__file__).resolve().parents[1]
SETUP = (REPOSITORY / 'setup.py').read_text(encoding='utf-8')
# Programs of others: their arguments are not checked.
FOREIGN = {'.', 'cd', 'export', 'git', 'grep', 'head', 'jq', 'less', 'ls', 'mkdir', 'mypy',
           'octave', 'ping', 'rosdep', 'rviz2', 'sed', 'sort', 'source', 'sudo', 'tail', 'wc',
           'xargs'}
_SEPARATORS = re.compile(r'&&|\|\||[|;&]')


class Failure(Exception):
    """A command is wrong."""


def check(line):
    """Raise Failure if a shell line holds a wrong command."""
    line = re.sub(r'\$\([^()]*\)', 'SUBSTITUTED', line)
    words = shlex.shlex(line, posix=True, punctuation_chars='&|;')
    words.whitespace_split = True
    command = []
    for word in (*words, '&&'):
        if not _SEPARATORS.fullmatch(word):
            command.append(word)
        elif command:
            _check_command(command)
            command = []


def _check_command(words):
    while words and re.match(r'[A-Z_]+=', words[0]):
        words = words[1:]
    if not words:
        return
    program, arguments = words[0].removeprefix('.venv/bin/').removeprefix('./'), words[1:]
    if program in FOREIGN or program.startswith(('.ci/', 'tools/')) and _exists(program):
        return
    if program not in CHECKERS:
        raise Failure(f'{program}: no checker for this program in document_commands.py')
    CHECKERS[program](arguments)


def _baxter_dynamics(arguments):
    try:
        parse(arguments)
    except SystemExit as end:
        if end.code:
            raise Failure(f'wrong arguments: {arguments}') from None


def _torque_predictor(arguments):
    given = _parameters(arguments)
    PredictorSettings.from_parameters({
        key: value for key, value in given.items()
        if not re.match(r'use_sim_time|qos_overrides|joint_prefix|frame_id', key)})


def _parameters(arguments):
    """Return the parameters of ROS arguments, such as -p arm:=left."""
    if arguments and arguments[0] != '--ros-args':
        raise Failure(f'{arguments[0]} without --ros-args')
    values = [value for flag, value in zip(arguments, arguments[1:]) if flag in ('-p', '--param')]
    if any(':=' not in value for value in values):
        raise Failure(f'a parameter without := in {values}')
    return {name: yaml.safe_load(value) for name, _, value in (
        value.partition(':=') for value in values)}


def _ros2(arguments):
    verb, names = arguments[0], arguments[1:]
    if verb == 'run' and names[0] == 'baxter_dynamics_ros':
        if f"'{names[1]} = " not in SETUP:
            raise Failure(f'no executable {names[1]}')
        CHECKERS[names[1]](names[2:])
    elif verb == 'launch' and names[0] == 'baxter_dynamics_ros':
        _exists(f'launch/{names[1]}')
        declared = {argument.get('name') for argument in ET.parse(
            REPOSITORY / 'launch' / names[1]).findall('arg')}
        unknown = {name.partition(':=')[0] for name in names[2:] if ':=' in name} - declared
        if unknown:
            raise Failure(f'{names[1]} has no argument {unknown}')
    elif verb not in ('run', 'launch', 'topic', 'service', 'action', 'param', 'node', 'bag',
                      'security', 'pkg', 'interface', 'doctor', 'daemon'):
        raise Failure(f'ros2 has no command {verb}')
    elif verb in ('topic', 'service', 'action'):
        _check_names(names)


def _check_names(names):
    """Check topics, services and actions below our nodes, and their types."""
    text = ''.join(path.read_text('utf-8') for path in (
        REPOSITORY / 'baxter_dynamics_ros' / 'nodes').glob('*.py'))
    for name in names:
        if re.match(r'(/\w+)*/(torque_predictor|fake_baxter)/', name):
            if not re.search(rf"[/']{name.rpartition('/')[2]}'", text):
                raise Failure(f'no topic, service or action {name}')
        if name.startswith('baxter_dynamics_interfaces/'):
            kind = name.split('/')[1]
            _exists(f'baxter_dynamics_interfaces/{name.partition("/")[2]}.{kind}')


def _python(arguments):
    if arguments[0] == '-c':
        ast.parse(arguments[1])
    elif arguments[0] == '-m':
        if arguments[1] not in ('venv', 'pip') and not importlib.util.find_spec(arguments[1]):
            raise Failure(f'no module {arguments[1]}')
    else:
        _exists(arguments[0])
        script = REPOSITORY / arguments[0]
        text = ''.join(path.read_text('utf-8') for path in script.parent.rglob('*.py'))
        for option in arguments[1:]:
            if option.startswith('--') and f"'{option.partition('=')[0]}'" not in text:
                raise Failure(f'{arguments[0]} has no option {option}')


def _pip(arguments):
    for word in arguments[1:]:
        path, extras = re.fullmatch(r'([^\[]*)(?:\[(.*)\])?', word).groups()
        if path.startswith('.'):
            _exists(f'{path}/pyproject.toml')
        for extra in (extras or '').split(','):
            if extra and f"'{extra}': " not in SETUP:
                raise Failure(f'no extra {extra}')


def _pytest(arguments):
    for word in arguments:
        if word.startswith('test/'):
            _exists(word.partition('::')[0])


def _colcon(arguments):
    for word in arguments:
        if word.startswith('src/baxter_dynamics_ros'):
            _exists(word.replace('src/baxter_dynamics_ros', '.', 1))


def _exists(path):
    if not (REPOSITORY / path).exists():
        raise Failure(f'there is no {path}')
    return True


CHECKERS = {
    'baxter_dynamics': _baxter_dynamics, 'torque_predictor': _torque_predictor,
    'fake_baxter': _parameters, 'joint_state_bridge': _parameters, 'ros2': _ros2,
    'python': _python, 'python3': _python, 'pip': _pip, 'pytest': _pytest, 'colcon': _colcon}

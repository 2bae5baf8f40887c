"""How each kind of command in the documents is run, or why it is not and what holds it then."""

import argparse
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
import os
import re

from document_processes import Failure
from document_setup import distributions, executables, extras, PACKAGE

WORKSPACE = f'src/{PACKAGE}'  # where the README has the repository on a ROS machine
PACKAGES = (PACKAGE, 'baxter_dynamics_interfaces')

# Appended: the last of an option counts.
SHORTER = {'experiment': ['--duration', '2']}
# These take long: the real parser has to accept them, and the test that runs them is named.
RUN_ELSEWHERE = {
    ('closed_form', 'sizes'):
        'test/closed_form/test_sizes.py::test_the_documented_table_is_the_commands',
    ('demo',): 'test/node/test_demo.py::test_shows_the_comparison_the_services_and_a_picture',
    ('calibrate', '--plan'):
        'test/test_experiment.py::test_plan_is_written_and_tried_on_the_fake_baxter',
}
# What asks others over the wire for ever: what ends it, and what it says when it has heard them.
FOR_EVER = {'watch': ({'--once', '--duration', '--help'}, 's0'),
            'topic echo': ({'--once'}, '---'), 'topic hz': ((), 'average rate'),
            'topic bw': ((), 'B/s'), 'topic delay': ((), 'average delay')}
# These need a ROS installation, a network, or a machine of its own: what runs them instead.
NOT_RUN = {
    'rosdep': 'test/test_package_xml.py::test_imports_are_declared_and_nothing_else_is',
    'colcon': 'test/test_colcon_build.py::test_executable_runs_from_the_workspace',
    'source': 'test/test_colcon_build.py::test_executable_runs_from_the_workspace',
    'ros2 security': 'test/node/test_sros2_policy.py::test_is_of_the_format_that_sros2_reads',
    'pip': 'test/test_install.py::test_command_runs',
    'git clone': 'test/test_install.py::test_command_runs',
    '-m venv':
        'test/test_documentation.py::test_continuous_integration_runs_the_readmes_test_command',
}
# Not set: the tests have a domain of their own, and the wheels' Fast DDS has no security.
LEFT_ALONE = re.compile('ROS_DOMAIN_ID|ROS_SECURITY_')


def baxter_dynamics(page, words):
    """Run a subcommand in this process, by the function that the command's name stands for."""
    _, name, *arguments = words + [''] * (len(words) < 2)
    for (elsewhere, *options), test in RUN_ELSEWHERE.items():
        if elsewhere == name and set(options) <= set(arguments):
            accepted(words[1:])
            _tested(page, test)
            return _planned(page, words)
    if name in FOR_EVER:
        return _on_the_wire(page, words, name)
    words = words + SHORTER.get(name, [])
    page.rest()
    page.stand_ins.provide(words, page.folder)
    return page.stand_ins.once(words, page.folder, lambda: _inside(words[1:], page.folder))


def node(page, words):
    """Start a node that runs for ever."""
    page.stand_ins.provide(words, page.folder)
    page.start(words)


def ros2(page, words):
    """Run what is called ros2 here; launch and run go on for ever, and so do some topics."""
    kind = ' '.join(words[1:3])
    if words[1:2] == ['security']:
        return _elsewhere(page, 'ros2 security')
    if words[1:4] == ['run', PACKAGE, 'baxter_dynamics']:
        return baxter_dynamics(page, words[3:])
    page.stand_ins.provide(words, page.folder)
    if words[1:2] in (['run'], ['launch']):
        return page.start(words) and None
    if words[1:2] == ['pkg']:
        return page.run(words)
    return _on_the_wire(page, words, kind)


def python(page, words):
    """Run a module; have a script's parser judge its command line, for tests run the scripts."""
    script, arguments = words[1], words[2:]
    if script == '-m':
        module, arguments = arguments[0], arguments[1:]
        if module == 'venv':
            return _elsewhere(page, '-m venv')
        if module in ('pytest', 'pip'):
            return RULES[module](page, [module, *arguments])
        if module.split('.')[0] != PACKAGE:
            raise Failure(f'{module}: say in document_rules.py how it is run')
        if (module.split('.')[-1], *arguments) in RUN_ELSEWHERE:
            return _tested(page, RUN_ELSEWHERE[(module.split('.')[-1], *arguments)])
        return page.stand_ins.once(words, page.folder, lambda: page.run(words))
    if script == '-c':
        return page.run(words)
    path = page.folder / script
    if not path.is_file() or path.parent.name not in ('benchmarks', 'examples', 'docs'):
        raise Failure(f'{script}: is not there, or say in document_rules.py how it is run')
    named = re.compile(rf'\b{path.stem}\b')
    tests = [file for file in (page.folder / 'test').rglob('test_*.py')
             if path.parent.name in (text := file.read_text('utf-8')) and named.search(text)]
    if not tests:
        raise Failure(f'no test runs {script}')
    if arguments:
        said = page.run([words[0], script, '--help'])
        listed = page.run([words[0], script, '--list']) if '--list' in said else ''
        for before, word in zip(['', *arguments], arguments):
            if not (before.startswith('-') or word in re.findall(r'[\w./-]+', said + listed)):
                raise Failure(f'{script} knows no {word}:\n{said}')


def pytest(page, words):
    """See that the arguments choose tests; all tests are run anyway."""
    options = argparse.ArgumentParser(prog='pytest', allow_abbrev=False)
    for flag in ('-s', '-q', '-v', '-x', '-rs'):
        options.add_argument(flag, action='store_true')
    for option in ('-n', '--dist', '--durations', '-m'):
        options.add_argument(option)
    options.add_argument('-k', default='test')
    options.add_argument('files', nargs='*', default=['test/test_tables.py'])
    chosen = _parsed(options, words[1:])
    for file in chosen.files:
        path = page.folder / file.split('::')[0]
        if not path.exists():
            raise Failure(f'there is no {path.name}')
        text = path.read_text('utf-8') if path.is_file() else f'def {path.name}('
        names = re.findall(r'^def (test\w*)\(', text, re.MULTILINE)
        if not any(_matches(chosen.k, f'{path.stem} {name}') for name in names
                   if name == file.partition('::')[2].partition('[')[0] or '::' not in file):
            raise Failure(f'no test in {file} is chosen')


def mypy(page, words):
    """See that a test runs it, for it takes long."""
    files = (page.root / 'test').rglob('test_*.py')
    if words[1:] or not any("'mypy'" in file.read_text('utf-8') for file in files):
        raise Failure('no test runs mypy')


def pip(page, words):
    """See that what pip shall install is there, without network."""
    installable(words, page.folder)
    _elsewhere(page, 'pip')


def on_a_ros_machine(page, words):
    """See that what is named is there; only a ROS machine can run it."""
    for word in words[1:]:
        if word.startswith(WORKSPACE) and not (
                page.folder / word.replace(WORKSPACE, '.', 1)).exists():
            raise Failure(f'there is no {word}')
    for before, word in zip(words, words[1:]):
        if before in ('--packages-select', '--packages-up-to') and word not in PACKAGES:
            raise Failure(f'there is no package {word}')
    _elsewhere(page, words[0])


def git(page, words):
    """Do nothing: there is no network."""
    _elsewhere(page, ' '.join(words[:2]))


def export(page, words):
    """Set variables for the commands that follow."""
    for word in words[1:]:
        name, is_set, value = word.partition('=')
        if not is_set:
            raise Failure(f'export {word}: no value')
        if not LEFT_ALONE.match(name):
            page.environment[name] = value


def cd(page, words):
    """Go into a folder."""
    (to,) = words[1:]
    if not (page.folder / to).is_dir():
        raise Failure(f'there is no folder {to}')
    page.folder = (page.folder / to).resolve()


RULES = {
    'baxter_dynamics': baxter_dynamics, 'fake_baxter': node, 'torque_predictor': node,
    'joint_state_bridge': node,
    'ros2': ros2, 'python': python, 'python3': python, 'pytest': pytest, 'pip': pip,
    'colcon': on_a_ros_machine, 'rosdep': on_a_ros_machine, 'source': on_a_ros_machine,
    'git': git, 'mypy': mypy, 'export': export, 'cd': cd,
}


def starts(words: list) -> set:
    """Return the executables that a command starts and leaves running."""
    from document_launch import nodes
    from document_setup import REPOSITORY
    nodes_of_ours = set(executables()) - {'baxter_dynamics'}
    if words[:2] == ['ros2', 'launch'] and len(words) > 3:
        given = dict(word.split(':=', 1) for word in words[4:] if ':=' in word)
        return {command[0] for command in nodes(REPOSITORY / 'launch' / words[3], given)}
    return nodes_of_ours & {words[3] if words[:2] == ['ros2', 'run'] and len(words) > 3
                            else words[0]}


def accepted(arguments):
    """Fail where the parser of baxter_dynamics refuses its arguments."""
    from baxter_dynamics_ros.cli.main import _parser
    _parsed(_parser(), arguments)


def _parsed(parser, arguments):
    said = StringIO()
    try:
        with redirect_stderr(said):
            return parser.parse_args(arguments)
    except SystemExit:
        raise Failure(said.getvalue()) from None


def _matches(expression, name):
    """Return whether pytest's -k chooses a test."""
    def found(word):
        return word[0] if word[0] in ('and', 'or', 'not') else str(word[0] in name)
    return eval(re.sub(r'\w+', found, expression))


def installable(words: list, folder):
    """Fail where pip is asked for what setup.py does not know, or a folder without package."""
    for word in words[2:]:
        path, extra = re.fullmatch(r'([^\[]*)(?:\[(.*)\])?', word).groups()
        known = word.startswith('-') or path in {'pip', *distributions()} or (
            path.startswith('.') and (folder / path / 'pyproject.toml').is_file())
        if words[1] != 'install' or not known or set((extra or '').split(',')) - {''} - extras():
            raise Failure(f'pip has no {word} to install')


def _on_the_wire(page, words, kind):
    page.need_robot()
    ends, sign = FOR_EVER.get(kind, (words, None))
    if set(ends) & set(words):
        return page.run(words)
    listener = page.start(words)
    said = page.wait_for(listener, sign)
    page.stop(listener)
    return said


def _inside(arguments, folder):
    from baxter_dynamics_ros.cli.main import main
    said, before = StringIO(), os.getcwd()
    os.chdir(folder)
    try:
        with redirect_stdout(said), redirect_stderr(said):
            code = main(arguments)
    except SystemExit as end:  # of the parser
        code = end.code
    finally:
        os.chdir(before)
    if code:
        raise Failure(f'exit code {code}\n{said.getvalue()}')
    return said.getvalue()


def _planned(page, words):
    """Put a bag where the plan's would be."""
    if '--plan' in words:
        folder = words[words.index('-o') + 1] if '-o' in words else 'baxter_plan'
        page.stand_ins.plan(page.folder / folder)


def _elsewhere(page, kind):
    _tested(page, NOT_RUN[kind])


def _tested(page, test):
    file, name = test.split('::')
    text = (page.root / file).read_text('utf-8') if (page.root / file).is_file() else ''
    if f'def {name}(' not in text:
        raise Failure(f'no test {test}, which shall run this')

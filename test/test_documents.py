"""Each page of the documents is worked through: its commands and programs run, its links lead."""

import os

from document_setup import REPOSITORY
import pytest

for module in ('markdown_it', 'rclpy', 'baxter_dynamics_interfaces.srv', 'mujoco', 'pinocchio',
               'rosbags', 'scipy', 'matplotlib', 'jinja2', 'rich', 'casadi'):
    pytest.importorskip(module, reason=f'needs {module}: pip install ".[test]"')

from document_checkout import checkout, launchers  # noqa: E402, I100
from document_page import Page  # noqa: E402
from document_spans import wrong  # noqa: E402
from document_stand_ins import StandIns  # noqa: E402
from markdown_blocks import anchors, blocks, commands, faults, INDENTED, links, words  # noqa: E402

PAGES = sorted(str(path.relative_to(REPOSITORY)) for pattern in (
    '*.md', 'docs/**/*.md', 'examples/**/*.md', 'benchmarks/**/*.md')
    for path in REPOSITORY.glob(pattern))


def text_of(page):
    """Return a page's text."""
    return (REPOSITORY / page).read_text(encoding='utf-8')


pytestmark = pytest.mark.timeout(300)  # a page takes seconds, but may wait for what never comes

# Commands that must not pass -> why.
WRONG = {
    'baxter_dynamics evaluat my_bag': "invalid choice: 'evaluat'",
    'baxter_dynamics evaluate my_bag --arms right': 'unrecognized arguments',
    'baxter_dynamics evaluate her_bag': 'her_bag: there is no such file',
    'baxter_dynamics demo --durations 3': 'unrecognized arguments',
    'baxter_dynamics calibrate --plan --seeds 3': 'unrecognized arguments',
    'baxter_dynamics evaluate my_bag > log': '>: say in document_page.py what it does',
    'rm -r report': 'rm: say in document_rules.py how it is run',
    '.venv/bin/pip install "numpy[all]"': 'pip has no numpy[all]',
    'pip install gone': 'pip has no gone',
    "pip install '.[gone]'": 'pip has no .[gone]',
    'colcon build --base-paths src/baxter_dynamics_ros/gone': 'there is no src/',
    'python examples/gone.py': 'examples/gone.py: is not there',
    'python benchmarks/model.py --fast': 'knows no --fast',
    'python -m baxter_dynamics_ros.gone': 'No module named',
    'pytest test/test_gone.py': 'there is no test_gone.py',
    'pytest test/test_tables.py -k "gone or not test"': 'no test in test/test_tables.py is chosen',
    'pytest --gone': 'unrecognized arguments: --gone',
    'ros2 run baxter_dynamics_ros gone': 'gone',
    'ros2 topic sing /robot/joint_states': 'sing',
    'ros2 launch baxter_dynamics_ros gone.launch.xml': 'gone.launch.xml',
    'fake_baxter --ros-args -p trajectory:=loop': 'has ended with exit code 1',
    'ros2 run baxter_dynamics_ros torque_predictor --ros-args -p arm:=head': 'has ended with',
}
WRONG_BLOCKS = """
```python
first = 1
```

```python
assert first == 2
```

```yaml
/**:
  ros__parameters:
    arm: right
    gone: 1.0
```

```json
{1: 2}
```

```xml
<a><b></a>
```

```
unlabelled
```

and

    indented
"""
FORM = """# One `x`, two

## One x two

| a | b |
|---|---|
| c |
| `a \\| b` | b |

<b>![](gone.png)
"""


@pytest.fixture(scope='module')
def reader(tmp_path_factory):
    """Return a function that makes a page of a text, in a checkout of its own."""
    folder = tmp_path_factory.mktemp('documents')
    stand_ins = StandIns(tmp_path_factory.mktemp('stand_ins'))
    path = None
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))
        patch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        patch.delenv('ROS_SECURITY_ENABLE', raising=False)

        def page(name, text):
            nonlocal path
            root = checkout(REPOSITORY, folder / str(len(list(folder.iterdir()))))
            path = path or launchers(tmp_path_factory.mktemp('path') / 'bin', root)
            return Page(name, text, root, path, stand_ins)

        yield page


@pytest.mark.parametrize('page', PAGES)
def test_everything_on_a_page_runs(reader, page):
    failures = reader(page, text_of(page)).work_through()
    assert not failures, '\n\n'.join(['', *failures])


def lost(path):
    """Return the links of a page that lead nowhere, a line each."""
    found = []
    for line, address, is_image, said in links(path.read_text(encoding='utf-8')):
        name, _, anchor = address.partition('#')
        target = path.parent / name if name else path
        if name.startswith(('http://', 'https://', 'mailto:')):
            continue
        if not target.exists():
            found.append(f'line {line}: there is no {name}')
        elif anchor and anchor not in anchors(target.read_text(encoding='utf-8')):
            found.append(f'line {line}: {target.name} has no heading #{anchor}')
    return found


@pytest.mark.parametrize('page', PAGES)
def test_a_page_is_in_good_form(page):
    found = [*faults(text_of(page)), *lost(REPOSITORY / page), *wrong(text_of(page), REPOSITORY)]
    assert not found, '\n'.join([page, *found])


def shell(*lines):
    """Return a page with commands, the first of which is on its second line."""
    return '\n'.join(['```bash', *lines, '```'])


def test_a_block_is_found_with_its_kind_and_line_and_commands_with_theirs():
    text = """- a list

  ```bash
  a '# b' c#d \\
    -e  # don't
  # no

  f
  ```
"""
    (block,) = blocks(text)
    assert (block.kind, block.line) == ('bash', 4)
    assert [(each.line, words(each.text)) for each in commands(block)] == [
        (4, ['a', '# b', 'c#d', '-e']), (8, ['f'])]
    assert [(each.kind, each.line) for each in blocks(WRONG_BLOCKS)] == [
        ('python', 3), ('python', 7), ('yaml', 11), ('json', 18), ('xml', 22), ('', 26),
        (INDENTED, 31)]


def test_what_a_command_does_wrong_is_told_with_its_line(reader):
    failures = reader('a page', shell(*WRONG)).work_through()
    found = {int(failure.split(':')[1]): failure for failure in failures}
    for line, (command, problem) in enumerate(WRONG.items(), 2):
        assert found[line].startswith(f'a page:{line}: {command}\n'), found[line]
        assert problem in found[line]
    assert len(failures) == len(WRONG)


def test_silence_is_a_failure(reader):
    page = reader('a page', shell(
        'ros2 topic echo /gone', 'ros2 service call /gone std_srvs/srv/Trigger'))
    page.need_robot = lambda: None
    page.environment['ROS2_STAND_IN_WAIT'] = '1'
    assert ['within 1 s' in failure for failure in page.work_through()] == [True, True]


def test_what_is_wrong_with_a_block_is_told_with_its_line(reader):
    page = reader('a page', WRONG_BLOCKS)
    failures = dict(failure.split(': ', 1) for failure in page.work_through())
    for line, problem in ((3, 'line 7, in <module>'), (11, 'gone'), (18, 'property name'),
                          (22, 'mismatched tag'), (26, 'say what it is'), (31, 'say what it is')):
        assert problem in failures.pop(f'a page:{line}')
    assert not failures


def test_faults_of_form_are_found():
    assert anchors(FORM) == ['one-x-two', 'one-x-two']
    assert faults(FORM) == [
        'two headings with the anchor #one-x-two', 'line 7: 1 cells in a table of 2 columns',
        'line 10: HTML: <b>', 'line 10: no text for gone.png']


def test_links_that_lead_nowhere_are_found(tmp_path):
    page = tmp_path / 'page.md'
    page.write_text('# A b\n\n[x](#a-b) [x](page.md#a-b) [x](https://example.org/#c)\n'
                    '![x](gone.png)\n\n[x](#c)\n[x](page.md#c)\n')
    assert lost(page) == ['line 3: there is no gone.png', 'line 6: page.md has no heading #c',
                          'line 6: page.md has no heading #c']


@pytest.mark.parametrize('code, problem', [
    ('baxter_dynamics experiment lop', 'invalid choice'),
    ('python docs/gone.py', 'there is no docs/gone.py'),
    ('python benchmarks/model.py --gone', 'knows no --gone'),
    ('python -m baxter_dynamics_ros.gone', 'there is no baxter_dynamics_ros.gone'),
    ('ros2 run baxter_dynamics_ros gone', 'there is no executable gone'),
    ("pip install '.[gone]'", 'pip has no')])
def test_a_command_within_a_sentence_could_be_run(code, problem):
    (found,) = wrong(f'One calls\n`{code}`.\n', REPOSITORY)
    assert found.startswith(f'line 1: `{code}`: ') and problem in found
    assert wrong('`baxter_dynamics evaluate BAG`, `rm x`, `python x`', REPOSITORY) == []

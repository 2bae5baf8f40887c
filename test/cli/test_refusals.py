"""What the commands refuse: one line, exit code 1 or 2, and nothing written."""

import os

import numpy as np
import pytest

TAKEN = 'exists; choose another name, or replace it with --force'
THEIRS = 'exists and was not written by an export; move it, or choose another name'
EITHER = 'expected either a language or --base-parameters'
ONLY_RIGHT = ('run: /robot/joint_states has no joints of the left arm, only right_e0, right_e1, '
              'right_s0, right_s1, right_w0, right_w1, right_w2; check --arm and the parameters '
              'arm and joint_prefix')

REFUSALS = [  # arguments, reason
    ('calibrate', 'expected a recording, or --plan to make one'),
    ('calibrate run --plan', '--plan takes no recordings'),
    ('calibrate --plan --payload', '--payload is not used with --plan'),
    ('calibrate run --max-velocity 0.4', '--max-velocity is used only with --plan'),
    ('calibrate run -o robot.txt',
     '--output: expected a name ending in .yaml or .yml, got robot.txt'),
    ('calibrate run -o file/r.yaml', '--output: {here}/file is not a folder'),
    ('calibrate run -o folder.yaml', '--output: {here}/folder.yaml is a folder'),
    ('calibrate run -o folder.yml', '--output: {here}/folder.html is a folder'),
    ('calibrate run -o report.yaml', '--output: {here}/report.html ' + TAKEN),
    ('calibrate run -o run/metadata.yaml --force',
     '--output: {here}/run/metadata.yaml belongs to the input run'),
    ('calibrate run --params robot.yaml -o link.yaml --force',
     '--output: {here}/link.yaml belongs to the input robot.yaml'),
    ('calibrate run --arm left', ONLY_RIGHT),
    ('demo --output none/demo.png', '--output: no folder {here}/none'),
    ('experiment lift -o theirs', '--output: {here}/theirs exists; choose another name'),
    ('calibrate --plan -o file', '--output: {here}/file is not a folder'),
    ('export', EITHER),
    ('export c --base-parameters', EITHER),
    ('export --base-parameters -o x', '--base-parameters prints a table and takes no --output'),
    ('export c -o my.c', '--output: expected a folder for 3 files'),
    ('export python -o theirs.py', '--output: {here}/theirs.py ' + THEIRS),
    ('export c -o theirs', '--output: {here}/theirs/example.c ' + THEIRS),
    ('export c -o loop', '--output: no folder {here}/loop'),
    ('export c -o ~nobody_here/x --params ~nobody_here/p.yaml',
     '~nobody_here/p.yaml: cannot be read (No such file or directory)'),
    ('evaluate none -o new', 'none: no such file or folder'),
    ('evaluate none.npz -o new', 'none.npz: no recordings'),
    ('evaluate run', '--output: {here}/baxter_evaluation ' + TAKEN),
    ('evaluate run -o run --force', '--output: {here}/run belongs to the input run'),
    ('evaluate run -o new --params left.yaml', ONLY_RIGHT),
    ('evaluate run -o new --topic /none', 'run: no joint states in CDR or ROS 1 encoding on '
     '/none; it has /robot/joint_states (sensor_msgs/msg/JointState, cdr)'),
    ('evaluate run -o new --save-bag run', '{here}/run: exists; choose a new folder or remove it '
     'first'),
    ('evaluate run -o new --save-bag ~no-user/new',
     '{here}/~no-user/new: no folder {here}/~no-user'),
    ('evaluate run -o new --save-bag new', '--save-bag: {here}/new is the folder of the report'),
    ('evaluate run left -o new --save-bag bag', '--save-bag: expected one recording, got 2'),
]


@pytest.fixture
def here(make_bag, moving_arm, tmp_path):
    """Return a folder with recordings of both arms, and other files of the user."""
    make_bag(moving_arm(30))
    make_bag(moving_arm(30, 'left'), name='left')
    nothing = np.zeros((0, 7))
    np.savez(tmp_path / 'none.npz', joint_names=['s0', 's1', 'e0', 'e1', 'w0', 'w1', 'w2'],
             period=0.01, recording=np.zeros(0, int), recording_names=np.array([], str),
             position=nothing, velocity=nothing, effort=nothing)
    for folder in ('folder.yaml', 'folder.html', 'baxter_evaluation', 'theirs'):
        (tmp_path / folder).mkdir()
    for file in 'file', 'report.html', 'baxter_evaluation/notes', 'theirs.py', 'theirs/example.c':
        (tmp_path / file).write_text('mine; made without baxter_dynamics export')
    (tmp_path / 'left.yaml').write_text('/**:\n  ros__parameters: {arm: left}\n')
    (tmp_path / 'robot.yaml').write_text('/**:\n  ros__parameters: {payload.mass: 0.3}\n')
    os.link(tmp_path / 'robot.yaml', tmp_path / 'link.yaml')
    (tmp_path / 'loop').symlink_to('loop')
    return tmp_path


def test_a_refusal_is_one_line_and_writes_nothing(refused, here):
    for words, line in REFUSALS:
        assert refused(*words.split()) == line.format(here=here)


def test_a_folder_that_cannot_be_written_is_refused_before_work_begins(refused, here, closed):
    (here / 'locked').mkdir()
    for words in ('evaluate run -o locked/below', 'calibrate run -o locked/robot.yaml',
                  'demo --output locked/demo.png', 'export c -o locked/arm'):
        for mode in 0o555, 0o000:
            with closed(here / 'locked', mode):
                assert refused(*words.split()) == (
                    f'--output: {here}/{words.split()[-1]} cannot be written (Permission denied)')


def test_a_deleted_current_folder_is_named(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tmp_path.rmdir()
    assert command('export', 'c') == (1, '', 'baxter_dynamics export: the current folder no '
                                      'longer exists: cd to another one\n')


def test_a_report_that_cannot_be_written_leaves_no_new_bag(command, here, monkeypatch):
    monkeypatch.chdir(here)
    (here / 'baxter_evaluation' / 'figures').write_text('mine')
    code, _, err = command('evaluate', 'run', '--save-bag', 'new', '--force')
    assert code == 1 and 'baxter_evaluation: cannot be written' in err
    assert 'figures is a file' in err and not (here / 'new').exists()


@pytest.mark.parametrize('arguments, problem', [
    ('', 'the following arguments are required: COMMAND'),
    ('fly', "invalid choice: 'fly'"),
    ('experiment lift --duration nan', 'expected 2 to 3600 seconds, got nan'),
    ('experiment lift --seed -1', 'expected 0 to 2147483647, got -1'),
])
def test_misuse_is_explained_with_exit_code_2(command, tmp_path, monkeypatch, arguments, problem):
    monkeypatch.chdir(tmp_path)
    code, out, err = command(*arguments.split())
    assert (code, out) == (2, '')
    assert problem in err and err.startswith('usage: baxter_dynamics')
    assert list(tmp_path.iterdir()) == []

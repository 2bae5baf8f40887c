"""The commands as processes: interrupted, misused, without extras; the paper's experiment."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

for module in ('rosbags', 'pinocchio', 'scipy', 'matplotlib', 'jinja2', 'rich'):
    pytest.importorskip(module, reason=f'needs {module}: pip install ".[offline]"')

BEGUN = 60.0  # [s] within which a command has opened its recording
ENDED = 10.0  # [s] within which an interrupted one has ended


@pytest.fixture
def start(tmp_path):
    """Return a function that starts a command in tmp_path; all have ended with the test."""
    processes = []

    def start_(*arguments, **environment):
        processes.append(subprocess.Popen(
            [sys.executable, '-m', 'baxter_dynamics_ros.cli.main', *map(str, arguments)],
            cwd=tmp_path, env={**os.environ, **environment}, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler)))
        return processes[-1]

    yield start_
    for process in processes:
        process.kill()
        process.communicate()


def wait_until_open(process, file):
    """Wait until a process has a file open."""
    limit = time.monotonic() + BEGUN
    folder = f'/proc/{process.pid}/fd'
    while process.poll() is None and time.monotonic() < limit:
        for descriptor in os.listdir(folder):
            try:
                if os.readlink(f'{folder}/{descriptor}') == str(file):
                    return
            except FileNotFoundError:  # closed meanwhile
                pass
        time.sleep(0.01)
    pytest.fail(f'{file} is not read: {process.communicate()}')


@pytest.mark.parametrize('arguments, by, code', [
    (('evaluate', 'run', '--output', 'report', '--save-bag', 'new'), signal.SIGINT, 130),
    (('calibrate', 'run'), signal.SIGTERM, 143),
], ids=['evaluate', 'calibrate'])
def test_an_interrupted_command_leaves_nothing_and_prints_nothing(
        start, make_bag, moving_arm, tmp_path, arguments, by, code):
    bag = make_bag(moving_arm(8000))  # takes seconds to read
    process = start(*arguments)
    wait_until_open(process, bag / 'run.mcap')
    time.sleep(0.3)  # while it reads
    assert process.poll() is None
    process.send_signal(by)
    out, err = process.communicate(timeout=ENDED)
    assert (process.returncode, out, err) == (code, '', '')
    assert [path.name for path in tmp_path.iterdir()] == ['run']


def test_help_needs_no_extra(tmp_path):
    libraries = ('jinja2', 'matplotlib', 'mcap', 'mujoco', 'pinocchio', 'rclpy', 'rich', 'rosbags',
                 'scipy', 'viser', 'yaml')
    code = (f'import sys; sys.modules.update(dict.fromkeys({libraries}))\n'
            'from baxter_dynamics_ros.cli.main import main, VERBS\n'
            'for verb in VERBS:\n'
            '    try:\n        main([verb, "--help"])\n'
            '    except SystemExit as end:\n        assert not end.code\n'
            'sys.exit(main(["watch"]))')
    done = subprocess.run([sys.executable, '-c', code], cwd=tmp_path, capture_output=True,
                          text=True, timeout=60)
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith('baxter_dynamics watch: ') and 'pip install ".[demo]"' in line


def test_a_process_prints_only_its_error_on_stderr(start, make_bag, moving_arm, tmp_path):
    """No warning of a library, and names that are not valid text are escaped."""
    bag = make_bag(moving_arm(60)).rename(tmp_path / 'caf\udce9')
    processes = {
        0: start('evaluate', bag, '--output', 'r\udce9', PYTHONIOENCODING='utf-8:strict'),
        1: start('evaluate', 'none'),
        2: start('evaluate', bag, '--arm', 'middle')}
    said = {code: process.communicate(timeout=BEGUN) for code, process in processes.items()}
    assert {code: process.returncode for code, process in processes.items()} == {
        code: code for code in processes}, said
    out, err = said[0]
    assert err == '' and out.splitlines()[-1] == f'report: {tmp_path}/r\\udce9/report.html'
    assert said[1] == ('', 'baxter_dynamics evaluate: none: no such file or folder\n')
    assert said[2][0] == '' and "invalid choice: 'middle'" in said[2][1]


def test_markup_and_escape_sequences_in_names_are_printed_as_text(
        command, make_bag, moving_arm, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('FORCE_COLOR', '1')  # with progress bars, as in a terminal
    bag = make_bag(moving_arm(60)).rename(tmp_path / 'run[draft]\x1b]0;forged\x07\n')
    code, out, err = command('evaluate', bag, '-o', 'rep[/b]')
    assert (code, err) == (0, '')
    assert out.splitlines()[-1] == f'report: {tmp_path}/rep[/b]/report.html'
    assert '\x1b]0;' not in out and 'run[draft]\\x1b]0;forged' in out
    code, out, err = command('evaluate', 'none[b]\x1b[31m')
    assert (code, out) == (1, '')
    assert err.startswith('baxter_dynamics evaluate: none[b]\\x1b[31m: ')


@pytest.mark.parametrize('arguments, problem', [
    ((), 'the following arguments are required: COMMAND'),
    (('fly',), "invalid choice: 'fly'"),
    (('evaluate',), 'the following arguments are required: BAG'),
    (('calibrate', '--only', 'luck'), "invalid choice: 'luck'"),
    (('experiment',), 'the following arguments are required: trajectory'),
    (('experiment', 'loop'), "invalid choice: 'loop'"),
    (('experiment', 'lift', '--duration', '1'), 'expected 2 to 3600 seconds, got 1'),
    (('experiment', 'lift', '--duration', 'nan'), 'expected 2 to 3600 seconds, got nan'),
    (('experiment', 'lift', '--rate', '75'), 'invalid choice: 75.0'),
    (('experiment', 'lift', '--seed', '-1'), 'expected 0 to 2147483647, got -1'),
], ids=lambda value: ' '.join(value) if isinstance(value, tuple) else '')
def test_misuse_is_explained_with_exit_code_2(command, tmp_path, monkeypatch, arguments, problem):
    monkeypatch.chdir(tmp_path)
    code, out, err = command(*arguments)
    assert (code, out) == (2, '')
    assert problem in err and err.startswith('usage: baxter_dynamics')
    assert list(tmp_path.iterdir()) == []


def test_experiment(command, refused, tmp_path, monkeypatch):
    pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')
    monkeypatch.chdir(tmp_path)
    code, out, err = command('experiment', 'lift', '--duration', '2', '--arm', 'left')
    assert (code, err) == (0, '')
    folder = tmp_path / 'baxter_experiment_lift'
    assert out.startswith('recorded 200 joint states of 2.0 s on /robot/joint_states: ')
    numbers = json.loads((folder / 'report' / 'summary.json').read_text())
    assert numbers['command'] == 'baxter_dynamics experiment lift --duration 2 --arm left'
    assert numbers['arm'] == 'left' and numbers['lagrange_euler']['count'] == 200 - 21
    assert np.max(numbers['lagrange_euler']['rms']) < 1.0
    again = command('evaluate', folder / 'bag', '--arm', 'left', '--output', 'again')
    assert again[0] == 0
    repeated = json.loads((tmp_path / 'again' / 'summary.json').read_text())
    assert repeated['lagrange_euler'] == numbers['lagrange_euler']
    assert 'is not empty; name a new folder' in refused('experiment', 'lift', '--duration', '2')

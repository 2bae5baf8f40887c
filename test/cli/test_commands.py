"""The commands as processes: interrupted, without extras, and with unusual names and settings."""

from contextlib import suppress
import os
import signal
import subprocess
import sys
import time

import pytest

for module in ('rosbags', 'pinocchio', 'scipy', 'matplotlib', 'jinja2', 'rich'):
    pytest.importorskip(module, reason=f'needs {module}: pip install ".[offline]"')

BEGUN = 60.0  # [s] within which a command has opened its recording
ENDED = 10.0  # [s] within which an interrupted one has ended


def wait_until_open(process, file):
    """Wait until a process has a file open."""
    limit = time.monotonic() + BEGUN
    folder = f'/proc/{process.pid}/fd'
    while process.poll() is None and time.monotonic() < limit:
        for descriptor in os.listdir(folder):
            with suppress(FileNotFoundError):  # closed meanwhile
                if os.readlink(f'{folder}/{descriptor}') == str(file):
                    return
        time.sleep(0.01)
    pytest.fail(f'{file} is not read: {process.communicate()}')


def test_an_interrupted_command_leaves_nothing_and_prints_nothing(
        start_command, make_bag, moving_arm, tmp_path):
    bag = make_bag(moving_arm(4000))  # takes seconds to read
    cases = [(start_command(*arguments), by) for arguments, by in (
        (('evaluate', 'run', '--output', 'report', '--save-bag', 'new'), signal.SIGINT),
        (('calibrate', 'run'), signal.SIGTERM))]
    for process, by in cases:
        wait_until_open(process, bag / 'run.mcap')
        time.sleep(0.2)  # while it reads
        assert process.poll() is None
        process.send_signal(by)
        out, err = process.communicate(timeout=ENDED)
        assert (out, err) == ('', '')
        # Within an import of Pinocchio, Python ends by the signal itself.
        assert process.returncode in (128 + by, -by)
    assert [path.name for path in tmp_path.iterdir()] == ['run']


def test_help_needs_no_extra(tmp_path):
    libraries = ('jinja2', 'matplotlib', 'mcap', 'mujoco', 'pinocchio', 'rclpy', 'rich', 'rosbags',
                 'scipy', 'viser', 'yaml')
    code = (f'import sys; sys.modules.update(dict.fromkeys({libraries}))\n'
            'from baxter_dynamics_ros.cli.main import main, VERBS\n'
            'for verb in ("--help", *VERBS):\n'
            '    assert f"baxter_dynamics_ros.cli.{verb}" not in sys.modules\n'
            '    try:\n        main([verb, "--help"])\n'
            '    except SystemExit as end:\n        assert not end.code\n'
            'sys.exit(main(["watch"]))')
    done = subprocess.run([sys.executable, '-c', code], cwd=tmp_path, capture_output=True,
                          text=True, timeout=60)
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith('baxter_dynamics watch: ') and 'pip install ".[demo]"' in line


def test_no_setting_of_the_user_changes_a_figure_and_no_library_prints_a_warning(
        command, start_command, make_bag, moving_arm, tmp_path):
    """Names that are not valid text are escaped."""
    bag = make_bag(moving_arm(60)).rename(tmp_path / 'caf\udce9')
    assert command('evaluate', bag, '--output', tmp_path / 'plain')[::2] == (0, '')
    (tmp_path / 'matplotlibrc').write_text('text.usetex: True\naxes.prop_cycle: cycler(lw=[9])\n')
    process = start_command('evaluate', bag, '--output', 'r\udce9', environment={
        'PYTHONIOENCODING': 'utf-8:strict', 'PATH': '',
        'MPLBACKEND': 'module://matplotlib_inline.backend_inline'})
    out, err = process.communicate(timeout=BEGUN)
    assert (process.returncode, err) == (0, '')
    assert out.splitlines()[-1] == f'report: {tmp_path}/r\\udce9/report.html'
    plain, other = ({path.name: path.read_bytes() for path in (tmp_path / folder).rglob('*.svg')}
                    for folder in ('plain', 'r\udce9'))
    assert plain and plain == other


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
    code, out, err = command('evaluate', 'bag', '--arm', '\x1b[31mforged')
    assert code == 2 and '\x1b' not in err

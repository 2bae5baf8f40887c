"""The watch command as a process: it shows the topics and restores the terminal."""

import fcntl
from functools import partial
import os
import pty
import select
import signal
import struct
import termios
import time

from baxter_dynamics_ros.model.joints import JOINTS
import numpy as np
import pytest

pytest.importorskip('rich', reason='needs rich: pip install ".[demo]"')

Q = np.array([0.2, -0.6, 0.3, 1.2, -0.4, 0.8, 0.5])  # [rad]
EFFORT = np.array([1.0, -20.0, -1.0, -9.0, 0.3, -0.5, 0.1])  # [N m]


@pytest.fixture
def watch(domain, start_command):
    """Return a function that starts the command."""
    return partial(start_command, 'watch')


def test_prints_once_what_the_topics_say(robot, predictor, watch):
    process = watch('--once', '--duration', '30')
    robot.move_until(lambda: process.poll() is not None, [(Q, np.zeros(7), EFFORT)])
    out, err = process.communicate()
    assert (process.returncode, err) == (0, ''), out
    predicted, residual = robot.predicted[-1].effort, robot.residual[-1].effort
    rows = {words[0]: words[1:4] for words in map(str.split, out.splitlines())
            if words and words[0] in JOINTS}
    for i, joint in enumerate(JOINTS):
        assert list(map(float, rows[joint])) == pytest.approx(
            [EFFORT[i], predicted[i], residual[i]], abs=0.006)
    assert '/torque_predictor  right arm' in out and '\x1b' not in out


def test_reports_a_missing_predictor_and_output_that_cannot_be_written(watch):
    """Each process takes seconds to start, so all run at once."""
    lines = watch('--duration', '3', '--node', '/robot_7/predictor')
    once = watch('--once', '--duration', '0.5')
    with open('/dev/full', 'w') as full:
        unwritable = watch('--duration', '1.2', stdout=full)
    closed = watch('--duration', '1.2', preexec_fn=lambda: os.close(1))
    out, err = lines.communicate(timeout=60.0)
    assert (lines.returncode, err) == (0, '')
    said = [line.split(' ', 1)[1] for line in out.splitlines()]
    assert said[0] == 'waiting for /robot_7/predictor'
    assert said[-1].startswith('no predictor /robot_7/predictor in ROS domain '
                               f'{os.environ["ROS_DOMAIN_ID"]}: is torque_predictor running')
    for process, code, error in (
            (once, 1, 'no data within 0.5 s'), (closed, 0, ''),
            (unwritable, 1, 'standard output: No space left on device\n')):
        err = process.communicate(timeout=60.0)[1]
        assert process.returncode == code
        assert err.startswith(error and f'baxter_dynamics watch: {error}')
        assert err.count('\n') == bool(error)


@pytest.mark.parametrize('end, code', [(signal.SIGTERM, 143), (b'q', 0)])
def test_restores_the_terminal_and_saves_a_figure(watch, tmp_path, end, code):
    ours, its = pty.openpty()
    fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack('HHHH', 24, 80, 0, 0))
    before, output = termios.tcgetattr(its), b''
    process = watch('--node', '/robot_7/predictor', '--save', tmp_path / 'watch.svg', stdin=its,
                    stdout=its, stderr=its, start_new_session=True,
                    environment={'TERM': 'xterm-256color'})

    def read_until(text):
        nonlocal output
        limit = time.monotonic() + 30.0
        while text not in output:
            left = max(limit - time.monotonic(), 0.0)
            assert left and select.select([ours], [], [], left)[0], output[-1000:]
            output += os.read(ours, 10_000)

    read_until(b'waiting for')
    os.write(ours, b'?')
    read_until(b'95 % of the residuals')
    assert not termios.tcgetattr(its)[3] & termios.ECHO
    os.write(ours, end) if isinstance(end, bytes) else process.send_signal(end)
    read_until(b'figure: ')
    assert process.wait(30.0) == code
    assert termios.tcgetattr(its) == before
    assert output.rindex(b'\x1b[?1049l') > output.rindex(b'\x1b[?1049h')  # main screen
    assert output.rindex(b'\x1b[?25h') > output.rindex(b'\x1b[?25l')  # cursor
    svg = (tmp_path / 'watch.svg').read_text('utf-8')
    assert 'predictor' in svg and 'url(http' not in svg and b'Traceback' not in output
    os.close(ours)
    os.close(its)

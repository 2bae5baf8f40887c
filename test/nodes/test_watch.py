"""The command watch as a process: it prints what the topics say, and leaves the terminal alone."""

import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import sys
import termios
import time

from baxter_dynamics_ros.model.joints import JOINTS
import numpy as np
import pytest

pytest.importorskip('rich', reason='needs rich: pip install ".[demo]"')

COMMAND = [sys.executable, '-m', 'baxter_dynamics_ros.cli.main', 'watch']
Q = np.array([0.2, -0.6, 0.3, 1.2, -0.4, 0.8, 0.5])  # [rad]
EFFORT = np.array([1.0, -20.0, -1.0, -9.0, 0.3, -0.5, 0.1])  # [N m]


@pytest.fixture
def watch(domain):
    """Return a function that starts the command; all have ended with the test."""
    processes = []

    def start(*arguments, **options):
        processes.append(subprocess.Popen(
            [*COMMAND, *arguments], **{'stdin': subprocess.DEVNULL, 'stdout': subprocess.PIPE,
                                       'stderr': subprocess.PIPE, **options}))
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.communicate()


def test_prints_once_what_the_topics_say(robot, predictor, watch):
    process = watch('--once', text=True, env={**os.environ, 'COLUMNS': '100'})
    begin, k = time.monotonic(), 0
    while process.poll() is None and k < 1500:
        robot.until(lambda: time.monotonic() >= begin + 0.01 * k, 5.0)
        robot.send_arm(10 ** 18 + k * 10_000_000, Q, np.zeros(7), EFFORT)
        k += 1
    out, err = process.communicate()
    assert (process.returncode, err) == (0, ''), out
    predicted, residual = robot.predicted[-1].effort, robot.residual[-1].effort
    rows = [line.split()[:5] for line in out.splitlines() if line[:2] in JOINTS]
    assert [joint for joint, *_ in rows] == list(JOINTS)
    for i, (_, *numbers) in enumerate(rows):
        measured, said, difference, _ = map(float, numbers)
        assert measured == pytest.approx(EFFORT[i], abs=0.006)
        assert said == pytest.approx(predicted[i], abs=0.006)
        assert difference == pytest.approx(residual[i], abs=0.006)
    assert 'joint states arrive on /robot/joint_states' in out
    assert 'right arm: ' in out and '\x1b' not in out


@pytest.mark.parametrize('sink, code, said', [
    ('>&-', 0, ''), ('>/dev/full', 1, 'the output cannot be written (No space left on device)')])
def test_output_that_goes_nowhere_is_told_in_a_line(domain, sink, code, said):
    done = subprocess.run(
        ['sh', '-c', f'exec "$@" {sink}', 'sh', *COMMAND, '--duration', '1.2'],
        stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, timeout=20.0)
    assert (done.returncode, done.stderr) == (code, said and f'baxter_dynamics watch: {said}\n')


def test_says_what_is_missing(watch):
    process = watch('--once', '--duration', '0.5', '--node', '/robot_7/predictor', text=True)
    out, err = process.communicate(timeout=20.0)
    assert (process.returncode, out) == (1, '')
    line, = err.splitlines()
    assert line.startswith('baxter_dynamics watch: nothing within 0.5 s: no predictor '
                           f'/robot_7/predictor in ROS domain {os.environ["ROS_DOMAIN_ID"]}: ')
    assert 'ROS_DOMAIN_ID?' in line


def test_leaves_the_terminal_as_it_was_and_a_picture(watch, tmp_path):
    ended = {signal.SIGINT: 130, signal.SIGTERM: 143, b'q': 0}
    terminals = {end: Terminal(watch, '--save', str(tmp_path / f'{code}.svg'))
                 for end, code in ended.items()}
    for end, terminal in terminals.items():
        terminal.until(b'is torque_predictor running')
        assert b'\x1b[?1049h' in terminal.shown  # its own screen
        assert not terminal.attributes()[3] & termios.ECHO
        if end == signal.SIGTERM:
            terminal.stop_and_continue()
        if isinstance(end, bytes):
            os.write(terminal.ours, end)
        else:
            terminal.process.send_signal(end)
    for end, terminal in terminals.items():
        assert terminal.process.wait(10.0) == ended[end]
        assert terminal.attributes() == terminal.before
        terminal.until(b'picture: ')
        assert 'torque_predictor' in (tmp_path / f'{ended[end]}.svg').read_text('utf-8')
        assert terminal.shown.rindex(b'\x1b[?1049l') > terminal.shown.rindex(b'\x1b[?1049h')
        assert terminal.shown.rindex(b'\x1b[?25h') > terminal.shown.rindex(b'\x1b[?25l')  # cursor
        assert b'Traceback' not in terminal.shown
        terminal.close()


class Terminal:
    """A terminal of 80 x 24 in which the command runs."""

    def __init__(self, watch, *arguments):
        self.ours, self._its = pty.openpty()
        fcntl.ioctl(self._its, termios.TIOCSWINSZ, struct.pack('HHHH', 24, 80, 0, 0))
        self.before = self.attributes()
        self.shown = b''
        self.process = watch(
            *arguments, stdin=self._its, stdout=self._its, stderr=self._its,
            start_new_session=True,
            env={**os.environ, 'TERM': 'xterm-256color', 'LANG': 'C.UTF-8'})

    def attributes(self):
        """Return how the terminal is set."""
        return termios.tcgetattr(self._its)

    def until(self, text):
        """Read what is shown until a text has come."""
        limit = time.monotonic() + 20.0
        while text not in self.shown:
            left = max(limit - time.monotonic(), 0.0)  # it draws on and on
            assert left and select.select([self.ours], [], [], left)[0], self.shown[-1000:]
            self.shown += os.read(self.ours, 10_000)

    def stop_and_continue(self):
        """Press Ctrl-Z, as a shell has it, look at what is left to the shell, and go on."""
        ours = self.attributes()
        self.process.send_signal(signal.SIGTSTP)
        self.until(b'\x1b[?1049l\x1b[?25h')
        assert os.WIFSTOPPED(os.waitpid(self.process.pid, os.WUNTRACED)[1])
        assert self.attributes() == self.before
        self.shown = b''
        self.process.send_signal(signal.SIGCONT)
        self.until(b'is torque_predictor running')
        assert self.shown.startswith(b'\x1b[?1049h\x1b[?25l')
        assert self.attributes() == ours

    def close(self):
        """Close both ends."""
        os.close(self.ours)
        os.close(self._its)

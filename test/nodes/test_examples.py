"""The ROS examples run as a reader would run them, beside the fake Baxter and the predictor."""

from contextlib import ExitStack
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import tempfile
import time

from baxter_dynamics_ros import JOINTS
from baxter_dynamics_ros.cli.processes import NodeProcess
import numpy as np
import pytest

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')
pytest.importorskip('baxter_dynamics_interfaces.srv',
                    reason='needs pip install ./baxter_dynamics_interfaces')

REPOSITORY = Path(__file__).resolve().parents[2]
TIME_LIMIT = 90.0  # [s]
NUMBER = re.compile(r'(?<![\w.])[+-]?\d+(?:\.\d+)?')
LOAD = np.array([1.0, 0.03, -0.02, 0.1])  # payload: mass [kg] and centre of mass [m]


class Example(NodeProcess):
    """An example as a process of its own, as in the background of a script: without SIGINT."""

    def __init__(self, name, *arguments, environment):
        self._output = tempfile.TemporaryFile('w+')
        path = os.pathsep.join([str(REPOSITORY), os.environ.get('PYTHONPATH', '')])
        subprocess.Popen.__init__(
            self, [sys.executable, REPOSITORY / 'examples' / f'{name}.py', *arguments],
            stdin=subprocess.DEVNULL, stdout=self._output, stderr=subprocess.STDOUT,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
            env={**environment, 'PYTHONPATH': path})

    def until(self, text, times=1):
        """Wait until it has printed a text so many times."""
        limit = time.monotonic() + TIME_LIMIT
        while self.output.count(text) < times:
            assert self.poll() is None and time.monotonic() < limit, self.output
            time.sleep(0.05)

    def finish(self):
        """Return what it prints until it ends by itself, without an error."""
        assert self.wait(TIME_LIMIT) == 0, self.output
        return self.output


def processes(*arguments, environment):
    """Return a fake Baxter with these parameters, and a predictor."""
    words = [word for each in arguments for word in ('-p', each)]
    return (NodeProcess('fake_baxter', ['--ros-args', *words], environment),
            NodeProcess('torque_predictor', (), environment))


@pytest.fixture(scope='module')
def finding_a_payload(domain):
    """Start the example about a payload, which takes its time, in a domain of its own."""
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(100 + int(os.environ['ROS_DOMAIN_ID']))}
    with ExitStack() as stack:
        for each in (*processes('trajectory:=poses', f'payload.mass:={LOAD[0]}',
                                f'payload.center_of_mass:={LOAD[1:].tolist()}',
                                environment=environment),
                     Example('payload_from_three_poses', environment=environment)):
            stack.enter_context(each)
        yield each


@pytest.fixture(scope='module')
def predictor(finding_a_payload):
    """Return a predictor beside a fake Baxter that holds still."""
    with ExitStack() as stack:
        for each in processes('trajectory:=hold', environment=os.environ):
            stack.enter_context(each)
        yield each


@pytest.fixture
def start(predictor):
    """Return a function that starts an example beside them."""
    with ExitStack() as stack:
        yield lambda *words: stack.enter_context(Example(*words, environment=os.environ))


def test_contact_warning_prints_begin_and_end_of_contact(start, predictor):
    warning = start('contact_warning')
    push = start('push', '--after', '0.5', '--duration', '30.0')
    push.until('pushed with')
    warning.until('contact for', 3)
    push.send_signal(signal.SIGINT)  # which lets go, too
    warning.until('contact is over after ')
    assert push.finish() == 'pushed with (0.0, 0.0, -25.0) N\nlet go\n'
    contacts = re.findall('contact for .*', warning.output)
    s1 = [re.search(r's1 external (\S+) residual ([^ ,]+)', line) for line in contacts]
    assert any(each and float(each[1]) > 8.0 and float(each[2]) < -8.0 for each in s1), contacts
    assert 'w2 ' not in contacts[-1]  # which the push does not reach

    os.kill(predictor.pid, signal.SIGSTOP)
    try:
        warning.until('no messages for 0.5 s: contact is unknown')
    finally:
        os.kill(predictor.pid, signal.SIGCONT)
    warning.send_signal(signal.SIGINT)
    assert 'Traceback' not in warning.finish()


def test_a_payload_is_found_from_three_postures(finding_a_payload):
    text = finding_a_payload.finish()
    mass, _, x, _, y, _, z, _ = map(float, NUMBER.findall(text.splitlines()[0]))
    np.testing.assert_allclose([mass, x, y, z], LOAD, atol=0.02)
    assert f'payload.mass {mass:.3f}' in text
    assert f'payload.center_of_mass "[{x}, {y}, {z}]"' in text


def test_gravity_compensation_holds_the_arm_which_falls_without(start):
    drifts = []  # of the joints [mrad]
    for options in ('--duration', '2'), ('--limp', '--duration', '0.6'):
        text = start('gravity_compensation', *options).finish()
        assert int(text.split()[0]) > 0  # torques
        drifts.append({line.split()[0]: float(line.split()[1]) for line in text.splitlines()[1:]})
        assert list(drifts[-1]) == list(JOINTS)
    held, fallen = (max(map(abs, drift.values())) for drift in drifts)
    assert held < 50.0 < fallen

"""The watch command: what is shown of the messages of a predictor."""

import io
import sys
from types import SimpleNamespace

from baxter_dynamics_ros.model.joints import joint_names, JOINTS
import numpy as np
import pytest

pytest.importorskip('rich', reason='needs rich: pip install ".[demo]"')
pytest.importorskip('rclpy', reason='needs ROS 2: pip install ".[ros]"')

from baxter_dynamics_ros.cli.monitor import Monitor, MonitoredPredictor  # noqa: E402, I100
from baxter_dynamics_ros.cli.terminal import plain_console  # noqa: E402
from baxter_dynamics_ros.cli.watch_view import bar, line, view  # noqa: E402
from baxter_dynamics_ros.nodes import topics  # noqa: E402
from baxter_dynamics_ros.nodes.messages import joint_state  # noqa: E402
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue  # noqa: E402
from rich.console import Console  # noqa: E402
from std_msgs.msg import Bool  # noqa: E402

PREDICTED = np.array([1.0, -20.0, 3.0, -8.0, 0.5, -0.6, 0.07])  # [N m]
RESIDUAL = np.array([0.11, -0.22, 0.33, -0.44, 0.55, -0.66, 0.77])
DEVIATION = np.array([0.1, 0.1, 0.2, 0.2, 0.3, 0.3, 0.3])  # [N m]
DELAY = 59_000_000  # [ns]


class Played(MonitoredPredictor):
    """A predictor whose messages are made here."""

    def effort(self, topic, values, stamp, now, order=JOINTS):
        """Receive efforts, the joints in an order."""
        self.receive(topic, joint_state(
            [f'right_{joint}' for joint in order], stamp,
            effort=np.array([values[JOINTS.index(joint)] for joint in order])), now)

    def diagnose(self, now, message='running', level=b'\x00', name='filter', **values):
        """Receive the diagnostics of the predictor, and of somebody else."""
        pairs = [KeyValue(key=key.replace('_', ' '), value=value) for key, value in values.items()]
        self.receive(topics.DIAGNOSTICS, DiagnosticArray(status=[
            DiagnosticStatus(name='other_node: filter', message='not ours'),
            DiagnosticStatus(name=f'torque_predictor: {name}', level=level, message=message,
                             values=pairs)]), now)

    def play(self, start, seconds, contact=False, order=JOINTS, with_effort=True):
        """Receive messages of 100 Hz in batches of five; return the time of the last."""
        for k in range(round(100 * seconds)):
            stamp, now = round((start + 0.01 * k) * 1e9), start + 0.05 * np.ceil(0.2 * k)
            for side in ('right', 'left'):
                self.receive(topics.JOINT_STATES, joint_state(joint_names(side), stamp), now)
            stamp -= DELAY
            self.effort(topics.PREDICTED_EFFORT, PREDICTED, stamp, now, order)
            if with_effort:
                self.effort(topics.EFFORT_RESIDUAL, RESIDUAL, stamp, now, order[::-1])
                self.effort(topics.RESIDUAL_DEVIATION, DEVIATION, stamp, now, order)
                self.effort(topics.EXTERNAL_EFFORT, -RESIDUAL, stamp + DELAY, now, order)
                self.receive(topics.CONTACT, Bool(data=contact), now)
        self.diagnose(now)
        return now


def shown(predictor, now, **options):
    """Return the view as text, 80 columns wide."""
    console = Console(file=io.StringIO(), width=80, markup=False, emoji=False, **options)
    console.print(view(predictor, now))
    return console.file.getvalue()


def row(text, joint):
    """Return the numbers of a joint: measured, predicted, residual and external."""
    words = next(line.split() for line in text.splitlines() if line.split()[:1] == [joint])
    return [*words[1:4], words[-1]]


@pytest.fixture
def predictor():
    """Return a predictor without data."""
    return Played('/torque_predictor')


@pytest.mark.parametrize('order', [JOINTS, tuple(sorted(JOINTS))], ids=' '.join)
def test_shows_efforts_by_joint_name_with_rates_delay_and_diagnostics(predictor, order):
    text = shown(predictor, predictor.play(5.0, 3.01, order=order))
    for i, joint in enumerate(JOINTS):
        assert row(text, joint) == [f'{value:+.2f}' for value in (
            PREDICTED[i] + RESIDUAL[i], PREDICTED[i], RESIDUAL[i], -RESIDUAL[i])]
    assert '/torque_predictor  right arm   no contact' in text and 'filter  OK  running' in text
    assert 'predictions 100.0 Hz, residuals 100.0 Hz, joint states 100.0 Hz, delay 59 ms' in text
    assert '│██████      ±0.20' in text  # s0
    assert max(map(len, text.splitlines())) <= 80 and 'not ours' not in text


def test_marks_residuals_beyond_the_expected_deviation(predictor):
    text = shown(predictor, predictor.play(5.0, 0.1), force_terminal=True, color_system='standard')
    lines = {joint: next(line for line in text.splitlines() if line.strip().startswith(joint))
             for joint in JOINTS}
    marked = [joint for joint, text in lines.items() if '\x1b[1;31m' in text]
    assert marked == ['s1', 'e1', 'w1', 'w2']
    assert '±0.39' in lines['e0']


def test_measured_predicted_and_residual_are_of_one_instant(predictor):
    for stamp in (1, 2):
        predictor.effort(topics.PREDICTED_EFFORT, stamp * PREDICTED, stamp, 5.0)
    predictor.effort(topics.EFFORT_RESIDUAL, RESIDUAL, 1, 5.0)
    assert predictor.efforts(5.0)[0, 1] == PREDICTED[1] + RESIDUAL[1]


def test_old_data_is_not_shown(predictor):
    text = shown(predictor, predictor.play(5.0, 2.0, contact=True) + 3.5)
    assert all(row(text, joint) == ['-', '-', '-', '-'] for joint in JOINTS)
    assert 'contact unknown' in text and 'no diagnostics' in text
    assert 'predictions 0.0 Hz' in text


def test_without_measured_effort_only_predictions_are_shown(predictor):
    now = predictor.play(5.0, 1.0, with_effort=False)
    assert row(shown(predictor, now), 's1')[1] == '-20.00'
    assert 'right arm: contact unknown; no residual' in line(predictor, now)


def test_contact_is_shown_with_its_joints_and_duration(predictor):
    now = predictor.play(5.0, 1.0)
    predictor.diagnose(now, joints_in_contact='w0')
    now = predictor.play(now + 0.01, 2.31, contact=True) - 0.001
    predictor.diagnose(now, joints_in_contact='s1, e0', explanation='1 kg at the hand')
    assert '1 kg at the hand' in shown(predictor, now)
    assert 'CONTACT for 2.3 s: s1, e0' in shown(predictor, now)
    assert 'CONTACT for 2.3 s: s1, e0; residual [N m] s0 +0.11' in line(predictor, now)
    now = predictor.play(now + 9.0, 0.51, contact=True)  # begun at any time in the pause
    assert 'CONTACT for over 0.5 s: ' in line(predictor, now)


@pytest.mark.parametrize('value, text', [
    (np.inf, '-'), (np.nan, '-'), (1e308, '+1.0e+308'), (-1e308, '-1.0e+308')])
def test_extreme_values_keep_the_layout(predictor, value, text):
    now = predictor.play(5.0, 0.1)
    predictor.effort(topics.PREDICTED_EFFORT, np.zeros(7), 9, now)
    predictor.effort(topics.EFFORT_RESIDUAL, np.full(7, value), 9, now)
    assert row(shown(predictor, now), 'w2')[2] == text


def test_escape_sequences_and_markup_are_shown_as_text(predictor):
    now = predictor.play(5.0, 0.1)
    predictor.diagnose(now, 'a\x1b[2J[/b]\nforged', b'\x01', '\x07[b]')
    text = shown(predictor, now)
    assert '\\x07[b]  WARN  a\\x1b[2J[/b]\\nforged' in text
    assert '\x1b' not in text and 'filter WARN' not in line(predictor, now)


def test_two_arms_share_the_subscriptions_of_joint_states_and_diagnostics():
    receive, running = {}, ['/right/predictor', '/left/predictor']

    def subscribe(kind, name, function):
        assert name not in receive
        receive[name] = function

    monitor = Monitor(SimpleNamespace(subscribe=subscribe, predictors=lambda: set(running)),
                      'predictor', '/joints', None)
    assert list(receive) == ['/joints', topics.DIAGNOSTICS]  # an invalid name is refused at once
    now = next(monitor.ticks(1.0, 1.0))
    receive[topics.DIAGNOSTICS](DiagnosticArray(status=[
        DiagnosticStatus(name=f'{name[1:]}: filter', message=name) for name in running]))
    assert sorted(each.diagnostics(now) for each in monitor.shown(now)) == [
        [('filter', 0, name)] for name in sorted(running)]


def test_a_bar_ends_at_the_limit_also_on_terminals_that_lack_its_characters(monkeypatch):
    assert bar(0.5, 1.0) == f'{"":10}│{"█████":10}'
    assert bar(-9.0, 1.0) == f'{"█" * 10}│{"":10}'
    assert bar(1e308, 1.0) == bar(1.0, 1.0)
    monkeypatch.setattr('sys.stdout', io.TextIOWrapper(io.BytesIO(), 'latin-1'))
    plain_console().print(f'±{bar(0.2, 1.0)}|')
    assert sys.stdout.buffer.getvalue().strip() == b'\xb1          ???        |'

"""The doctor on a real ROS 1 master, on ROS 2 and on recorded joint states."""

import json
from types import SimpleNamespace

from baxter_dynamics_ros.cli.doctor import _contents, _residuals, _stream, robot_checks
from baxter_dynamics_ros.cli.main import main
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
from baxter_dynamics_ros.ros1.source import Source
from baxter_dynamics_ros.ros1.wire import JointState
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import numpy as np
import pytest
from robot_node import PATIENCE
from ros1_processes import available, MISSING, Ros1

NAMES = (*joint_names('right'), *joint_names('left'), 'l_gripper_l_finger_joint')
POSTURE = np.array([0.1, -0.5, 0.2, 1.1, 0.1, 0.6, 0.2])  # [rad]
QUANTUM = 3.927e-4  # of the velocity [rad/s]


def rows(n, **changes):
    """Return joint states of two arms at rest: stamp [ns], names, position, velocity, effort."""
    random = np.random.default_rng(0)
    model = PredictorSettings().model
    still = np.zeros(7)
    static = model.effort_model.effort(model.arm.gravity(POSTURE), POSTURE, still, still)
    made = []
    for k in range(n):
        qd = QUANTUM * random.integers(-30, 30, 15)
        effort = np.concatenate([static, static, [0.0]]) + random.normal(0.0, 0.03, 15)
        row = {'names': NAMES, 'q': np.array([*POSTURE, *POSTURE, 0.0]), 'qd': qd,
               'effort': effort}
        row.update({key: change(row[key]) for key, change in changes.items()})
        made.append((10 ** 18 + k * 10 ** 7, list(row['names']),
                     *(list(map(float, row[key])) for key in ('q', 'qd', 'effort'))))
    return made


@pytest.fixture
def doctor(domain, monkeypatch, capsys):
    """Return a function that runs a quick doctor: exit code, and lines by the steps' names."""
    monkeypatch.setattr('baxter_dynamics_ros.cli.doctor._LOOK', 1.0)
    monkeypatch.setattr('baxter_dynamics_ros.cli.doctor._PATIENCE', PATIENCE)

    def run(*arguments):
        code = main(['doctor', *arguments])
        lines = capsys.readouterr().out.splitlines()
        return code, {line[6:19].strip(): (line[:6].strip(), line[19:]) for line in lines}
    return run


def test_every_step_passes_from_a_robot_to_the_residual(doctor, start, tmp_path, monkeypatch):
    if not available():
        pytest.skip(MISSING)
    played = tmp_path / 'rows.json'
    played.write_text('\n'.join(map(json.dumps, rows(2000))))
    with Ros1() as ros1:
        arms = ros1.publish('--play', played, '--name', 'arms', '--subscribers', 2,
                            address='011303P0017.local')  # 20 s from the doctor's connection on
        start('joint_state_bridge', '-p', f'master_uri:={ros1.uri}')
        start('torque_predictor', '-r', '__ns:=/right')
        code, lines = doctor(ros1.uri)
        assert code == 0, lines
        assert all(word == 'ok' for word, _ in lines.values())
        assert list(lines) == [
            'name', 'route', 'master', 'topic', 'publishers', 'address', 'message', 'rate',
            'lost', 'clock', 'arms', 'right effort', 'right arm', 'left effort', 'left arm',
            'ROS 2', 'ROS 2 topic', 'ROS 2 data', 'residual']
        assert '/arms at http://011303P0017.local' in lines['publishers'][1]
        assert 'does not resolve: using the address of the master' in lines['publishers'][1]
        assert lines['arms'][1] == 'arms: right, left; grippers: left'
        assert '3.927e-04 rad/s' in lines['right arm'][1]
        assert 'joint_state_bridge (reliable, volatile)' in lines['ROS 2 topic'][1]
        assert not any('/doctor' in name for name in str(ros1.state()[1]).split("'"))

        *_, topic = robot_checks(ros1.uri, '/joint_states')
        assert topic == ('topic', False, '/joint_states is not published',
                         'give one of /robot/joint_states as --topic')
        ros1.kill(arms)
        monkeypatch.setattr('baxter_dynamics_ros.cli.doctor._PATIENCE', 3.0)
        *_, port = robot_checks(ros1.uri, '/robot/joint_states')
        assert '/arms at http://011303P0017.local' in port.found and 'cleanup' in port.remedy


def test_without_an_address_it_checks_ros_2_alone(doctor, monkeypatch):
    monkeypatch.setattr('baxter_dynamics_ros.cli.doctor._PATIENCE', 0.5)
    code, lines = doctor()
    assert code == 1 and list(lines) == ['ROS 2', 'ROS 2 topic']
    assert 'start joint_state_bridge' in lines['ROS 2 topic'][1]
    assert doctor('--topic', 'a b')[0] == 1


def test_a_missing_residual_repeats_the_latest_diagnostics_of_its_predictor():
    def report(name, level):
        return DiagnosticArray(status=[DiagnosticStatus(name=name, level=level, message=name)])
    names = ['/left/p']  # the other is discovered later
    listener = SimpleNamespace(
        predictors=lambda: set(names), joint_states=lambda topic: names.append('/right/p') or [],
        wait=lambda condition, seconds: bool(condition()))
    check, other = _residuals(listener, [
        report('left/p: input', b'\2'), report('left/p: filter', b'\1'),
        report('right/torque_predictor: input', b'\2'), report('left/p: input', b'\0')])
    assert (check.remedy, other.passed) == ('left/p: filter', False) and '/right/p/' in other.found


def test_messages_lost_before_the_look_are_not_counted(monkeypatch):
    monkeypatch.setattr('baxter_dynamics_ros.cli.doctor._LOOK', 0.01)
    source = Source('/robot')
    source.lost = 5
    checks = _stream(SimpleNamespace(sources=lambda topic: [source], malformed=0), '')
    lost, = (check for check in checks if check.name == 'lost')
    assert lost.passed and lost.found.startswith('0 messages lost')


@pytest.mark.parametrize('changes, name, found', [
    ({}, 'left effort', 'plausible, offset at s1 '),
    ({'effort': lambda x: 0.0 * x}, 'right effort', 'zero at all joints'),
    ({'effort': lambda x: np.nan * x}, 'left effort', 'effort missing or not'),
    ({'effort': lambda x: []}, 'right effort', 'effort missing or not'),
    ({'q': lambda x: np.nan * x}, 'left effort', 'position missing or not'),
    ({'effort': lambda x: -x}, 'right effort', 'opposite sign'),
    ({'effort': lambda x: x + 34.0 * (np.arange(15) == 1)}, 'right effort', 's1 +3'),
    ({'names': lambda x: x[1:] + ('x',)}, 'arms', 'arms: left; grippers: left'),
    ({'names': lambda x: ['x'] * 15}, 'arms', 'arms: none; grippers: none'),
])
def test_joint_states_are_judged(changes, name, found):
    states = [JointState(k, *row[:1], '', *row[1:]) for k, row in enumerate(rows(50, **changes))]
    checks = {check.name: check for check in _contents(states)}
    assert found in checks[name].found, checks
    assert checks[name].passed == found.startswith(('plausible', 'arms: left'))


@pytest.mark.parametrize('recording, quantum, offset', [
    ('baxter_kitting', '3.927e-04', False), ('baxter_hand_guided', '3.745e-04', True)])
def test_real_robots_are_recognised(recordings, recording, quantum, offset):
    with np.load(recordings / f'{recording}.npz') as file:
        names = [str(name) for name in file['names']]
        columns = [file[key][:400] for key in ('position', 'velocity', 'effort')]
    states = [JointState(k, 0, '', names, *row) for k, row in enumerate(zip(*columns))]
    checks = {check.name: check for check in _contents(states)}
    assert quantum in checks['right arm'].found and checks['arms'].passed
    assert checks['right effort'].passed != offset, checks

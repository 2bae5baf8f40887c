"""The bridge between a real ROS 1 master, real rospy publishers, and ROS 2."""

import json
import signal
import time

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.nodes import joint_state_bridge
import numpy as np
import pytest
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from ros1_processes import available, MISSING, Ros1
from sensor_msgs.msg import JointState

TOPIC = '/robot/joint_states'
ARMS = ('head_nod head_pan left_e0 left_e1 left_s0 left_s1 left_w0 left_w1 left_w2 right_e0 '
        'right_e1 right_s0 right_s1 right_w0 right_w1 right_w2 torso_t0')
GRIPPERS = 'l_gripper_l_finger_joint l_gripper_r_finger_joint'
BEGIN = 1_500_000_000_123_456_789  # [ns]


@pytest.fixture
def ros1():
    """Return ROS 1: a master, and publishers on demand."""
    if not available():
        pytest.skip(MISSING)
    with Ros1() as running:
        yield running


@pytest.fixture
def bridge(robot, start, ros1):
    """Return a function that starts the bridge with parameters, and waits for its topic."""
    def start_(*parameters):
        robot.bridged = robot.listen(JointState, TOPIC)
        process = start('joint_state_bridge', '-p', f'master_uri:={ros1.uri}',
                        *(word for each in parameters for word in ('-p', each)))
        robot.until(lambda: robot.count_publishers(TOPIC) == 2)  # one is the test's own
        robot.until(lambda: TOPIC in ros1.state()[1])
        robot.report('joint_state_bridge')  # now it knows the test's subscriptions
        return process
    yield start_
    robot.forget()  # the end of the predictor waits for all subscriptions to end


def status(robot, name):
    """Return the next status of the bridge: level, message, values."""
    return robot.report('joint_state_bridge')[name]


def test_two_publishers_are_bridged_and_the_master_is_unchanged(robot, bridge, ros1, stamps):
    before = ros1.everything()
    process = bridge('clock:=robot', f'topics:=[{TOPIC}, {TOPIC}]')
    ros1.publish('--name', 'arms', '--joints', ARMS, '--count', 100, '--begin', BEGIN)
    # A host that does not resolve, as the robot's: the master's address serves.
    ros1.publish('--name', 'grippers', '--joints', GRIPPERS, '--count', 38, '--begin', BEGIN,
                 '--rate', 38, address='011303P0017.local')
    during = ros1.everything()
    robot.until(lambda: len(robot.bridged) >= 138, fail=False)
    robot.spin(0.3)
    assert len(robot.bridged) == 138, process.output
    for name, rate, count in (('right_s0', 100, 100), ('l_gripper_l_finger_joint', 38, 38)):
        messages = [message for message in robot.bridged if name in message.name]
        assert stamps(messages) == [BEGIN + round(k * 1e9 / rate) for k in range(count)]
        for k, message in enumerate(messages):
            values = [k + 0.001 * i for i in range(len(message.name))]
            assert list(message.position) == values
            assert list(message.velocity) == [-x for x in values]
            assert list(message.effort) == [2 * x for x in values]
        assert list(messages[0].name) == (ARMS if rate == 100 else GRIPPERS).split()
    assert '011303P0017.local does not resolve: using the address of the master' in process.output

    _, message, values = status(robot, TOPIC)
    assert values['other publishers in ROS 2'] == '1', message  # the test's own
    assert [values[f'/{name} {key}'] for name in ('arms', 'grippers')
            for key in ('received', 'lost', 'repeated')] == ['100', '0', '0', '38', '0', '0']
    level, message, values = status(robot, 'master')
    assert (level, values['reachable from the master']) == (b'\x00', 'True'), message
    offered, = [info.qos_profile for info in robot.get_publishers_info_by_topic(TOPIC)
                if info.node_name == 'joint_state_bridge']
    assert (offered.reliability, offered.durability) == (
        ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)

    # The bridge subscribes, and leaves no trace in the state, the types or the parameters.
    (publishers, subscribers, services), types, parameters = during
    ours = [name for name in subscribers[TOPIC] if name.startswith('/joint_state_bridge')]
    assert len(ours) == 1
    assert ours[0] not in str(publishers) + str(services) + str(parameters)
    assert process.end(signal.SIGHUP) == 0  # the terminal was closed
    (publishers, subscribers, services), types, parameters = ros1.everything()
    assert subscribers == {} and parameters == before[2]
    assert set(publishers[TOPIC]) == {'/arms', '/grippers'}
    assert 'joint_state_bridge' not in str((publishers, services, types))


def test_messages_return_after_each_fault_with_shifted_stamps(robot, bridge, ros1, stamps):
    process = bridge()

    def returns(after):
        since = time.time_ns()
        robot.until(lambda: stamps(robot.bridged[-1:]) > [since], 10.0)
        late = (time.time_ns() - stamps(robot.bridged[-1:])[0]) * 1e-9
        assert -0.2 < late < 2.0, (after, process.output)

    def publish(*arguments, **options):
        return ros1.publish('--joints', ARMS, '--behind', 2.6, *arguments, **options)

    publisher = publish()
    returns('first publisher')
    ros1.kill(publisher)
    publisher = publish()
    returns('publisher killed and restarted')

    publisher.send_signal(signal.SIGSTOP)
    robot.until(lambda: f'nothing has arrived on {TOPIC} for 2 s' in status(robot, TOPIC)[1])
    assert status(robot, TOPIC)[0] == b'\x02'
    publisher.send_signal(signal.SIGCONT)
    returns('publisher stopped for some seconds')

    ros1.kill(ros1.master)
    newest = len(robot.bridged)
    robot.until(lambda: 'is closed: check host and port' in status(robot, 'master')[1])
    assert len(robot.bridged) > newest + 10  # publishers need no master
    ros1.master = ros1.start_master()
    robot.until(lambda: TOPIC in ros1.state()[1])
    ros1.kill(publisher)
    publisher = publish(address='127.0.0.2')
    returns('master restarted, publisher at another address')
    values = status(robot, TOPIC)[2]
    assert values['/robot repeated'] == '0'
    assert 2.59 < float(values['/robot clock offset [s]']) < 3.1

    ros1.kill(ros1.master)
    ros1.kill(publisher)
    robot.until(lambda: status(robot, 'master')[0] == b'\x02')
    ros1.start_master()
    publish('--name', 'other')
    returns('master and publisher restarted')
    assert status(robot, TOPIC)[2]['/other repeated'] == '0'
    assert process.end() == 0
    assert ros1.state()[1] == {}


def test_recording_gives_the_offline_residual(robot, bridge, ros1, recordings, tmp_path, stamps):
    with np.load(recordings / 'baxter_kitting.npz') as file:
        chosen = np.flatnonzero(file['recording'] == 0)[:600]
        names = [str(name) for name in file['names']]
        rows = [(BEGIN + round((stamp - file['stamp'][chosen[0]]) * 1e9), names, *fields)
                for stamp, *fields in zip(*(file[key][chosen].tolist() for key in (
                    'stamp', 'position', 'velocity', 'effort')))]
    played = tmp_path / 'rows.json'
    played.write_text('\n'.join(map(json.dumps, rows)))
    predictor = Predictor(PredictorSettings(arm='right'))
    offline = [made for stamp, names, *fields in rows if (made := predictor.handle(
        stamp, names, *map(np.array, fields)).prediction) is not None]
    assert len(offline) > 100

    bridge('clock:=robot')
    robot.start_predictor()
    robot.report('joint_state_bridge')  # now it knows the predictor's subscription
    ros1.publish('--play', played, '--rate', 400)
    robot.until(lambda: len(robot.bridged) == len(rows))
    robot.until(lambda: len(robot.residual) == len(offline))
    assert stamps(robot.bridged) == [row[0] for row in rows]
    assert stamps(robot.residual) == [made.stamp_ns for made in offline]
    live, wanted = (np.array(list(residuals)) for residuals in (
        (message.effort for message in robot.residual), (made.residual for made in offline)))
    np.testing.assert_allclose(live, wanted, rtol=0, atol=1e-9)


def test_unusable_parameters_are_refused(refusals, monkeypatch):
    monkeypatch.delenv('ROS_MASTER_URI', raising=False)
    uri = 'master_uri:=http://robot:11311'
    cases = {
        ('topics:=[/robot/joint_states]',): 'expected the URI of the ROS 1 master',
        ('master_uri:=https://robot:11311',): "'https://robot:11311' is not the URI of a ROS 1",
        (uri, 'clock:=mine'): 'expected one of local, robot, receipt',
        (uri, 'topics:=[joint_states]'): 'expected full topic names',
        (uri, 'topics:=[]'): 'expected full topic names',
        (uri, 'clocks:=robot'): 'did you mean clock?'}
    for problem, line in zip(cases.values(), refusals('joint_state_bridge', list(cases))):
        assert problem in line


def test_waits_for_a_missing_robot(robot, start):
    process = start('joint_state_bridge', '-p', 'master_uri:=http://no-such-robot.local:11311',
                    '-p', 'topics:=[/arms]', '-r', f'/arms:={TOPIC}')
    robot.until(lambda: 'no-such-robot.local does not resolve' in process.output)
    assert 'add the name to /etc/hosts' in process.output
    robot.until(lambda: status(robot, '/arms')[2]['other publishers in ROS 2'] == '1')  # our own
    assert process.end() == 0


def test_registers_only_once_nothing_else_can_fail(robot, monkeypatch):
    monkeypatch.setenv('ROS_MASTER_URI', 'http://127.0.0.1:1')
    monkeypatch.setattr(joint_state_bridge, 'Subscriber', lambda *given: pytest.fail())
    monkeypatch.setattr(joint_state_bridge, 'DiagnosticUpdater', lambda *given: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        joint_state_bridge.JointStateBridge()

"""Reading of joint states from bags of every kind."""

from pathlib import Path
import sqlite3

from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

pytest.importorskip('rosbags', reason='reading bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.recordings.reader import BagRecording  # noqa: E402, I100

TOPIC = '/robot/joint_states'
START = 1_700_000_000_123_456_789  # [ns]
PERIOD = 10_000_000  # [ns]
RIGHT, LEFT = joint_names('right'), joint_names('left')
ROBOT = ('head_nod', 'head_pan', *LEFT, *RIGHT, 'torso_t0')
GRIPPER = ('r_gripper_l_finger_joint', 'r_gripper_r_finger_joint')
KINDS = ['mcap', 'sqlite3', 'ros1']


def states(n, names=RIGHT, topic=TOPIC, start=START):
    """Return n joint states with values of their own, received 1 ms after their stamps."""
    draw = np.random.default_rng(n).normal
    return [(topic, start + i * PERIOD + 1_000_000,
             (start + i * PERIOD, names, *draw(size=(3, len(names))))) for i in range(n)]


def assert_played(recording, messages):
    """Assert that a recording yields the joint states in messages, all and in this order."""
    played = list(recording)
    assert len(played) == recording.count == len(messages)
    for state, (_, received_ns, (stamp_ns, names, *arrays)) in zip(played, messages):
        assert (state.stamp_ns, tuple(state.names)) == (stamp_ns, tuple(names))
        assert state.received_ns == received_ns
        for array, wanted in zip(state[2:5], arrays):
            assert array.dtype == np.float64
            np.testing.assert_array_equal(array, wanted)


@pytest.mark.parametrize('kind, compression', [
    ('mcap', None), ('mcap', 'FILE'), ('mcap', 'MESSAGE'), ('mcap', 'STORAGE'),
    ('sqlite3', None), ('sqlite3', 'FILE'), ('sqlite3', 'MESSAGE'),
    ('ros1', None), ('ros1', 'LZ4'), ('ros1', 'BZ2')])
def test_plays_what_was_recorded(make_bag, kind, compression):
    messages = states(50)
    others = [('/talk', received_ns, 'hello') for _, received_ns, _ in messages]
    path = make_bag(others + messages, kind, 'morning.run', compression)
    with BagRecording(path) as recording:
        assert (recording.path, recording.name) == (path, 'morning.run')
        assert (recording.topic, recording.arm) == (TOPIC, 'right')
        assert_played(recording, messages)
        assert_played(recording, messages)  # and again


@pytest.mark.parametrize('kind, ending', [('mcap', '.mcap'), ('sqlite3', '.db3')])
def test_one_file_of_a_folder(make_bag, monkeypatch, kind, ending):
    messages = states(5)
    monkeypatch.chdir(make_bag(messages, kind))
    with BagRecording(Path(f'run{ending}')) as recording:
        assert recording.name == 'run'
        assert_played(recording, messages)


@pytest.mark.parametrize('kind', KINDS)
def test_messages_come_in_the_order_of_receipt(make_bag, rng, kind):
    messages = states(40)
    mixed = [messages[i] for i in rng.permutation(40)]
    with BagRecording(make_bag(mixed, kind)) as recording:
        assert_played(recording, messages)


@pytest.mark.parametrize('kind', KINDS)
def test_odd_contents_are_passed_on(make_bag, kind):
    nan = np.full(7, np.nan)
    messages = [(TOPIC, START + i, (i + 1, names, *arrays)) for i, (names, *arrays) in enumerate([
        (RIGHT, nan, nan, nan), (RIGHT, [], [], []), (RIGHT, [1.0], [2.0, 3.0], []),
        (GRIPPER, [1.0, 2.0], [], []), ((), [], [], []), (('', 'é'), [1.0, 2.0], [], [3.0])])]
    with BagRecording(make_bag(messages, kind)) as recording:
        assert_played(recording, messages)


def test_all_publishers_of_a_ros1_topic_are_read(make_bag, tmp_path):
    from rosbags.rosbag1 import Reader, Writer
    arms, grippers = states(30), states(10, GRIPPER, start=START + 1)
    messages = sorted(arms + grippers, key=lambda message: message[1])
    with Reader(make_bag(messages, 'ros1', 'one')) as reader, Writer(tmp_path / 'two.bag') as two:
        (known,) = reader.connections
        publishers = {names: two.add_connection(
            known.topic, known.msgtype, msgdef=known.msgdef.data, md5sum=known.digest,
            callerid=names[0]) for names in (RIGHT, GRIPPER)}
        for (_, received_ns, raw), message in zip(reader.messages(), messages):
            two.write(publishers[message[2][1]], received_ns, raw)
    with BagRecording(tmp_path / 'two.bag') as recording:
        assert_played(recording, messages)


def test_bags_without_message_definitions_are_read(make_bag, tmp_path):
    """As recorded by Foxy: neither definitions nor hashes."""
    messages = states(8)
    path = make_bag(messages, 'sqlite3', 'new')
    old = tmp_path / 'old'
    old.mkdir()
    with sqlite3.connect(old / 'old_0.db3') as database:
        database.executescript(f"""
            ATTACH '{path / 'new.db3'}' AS new;
            CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT,
                                serialization_format TEXT, offered_qos_profiles TEXT);
            INSERT INTO topics SELECT id, name, type, serialization_format, '' FROM new.topics;
            CREATE TABLE messages AS SELECT * FROM new.messages""")
    database.close()
    (old / 'metadata.yaml').write_text(f"""
rosbag2_bagfile_information:
  version: 4
  storage_identifier: sqlite3
  relative_file_paths: [old_0.db3]
  duration: {{nanoseconds: 1}}
  starting_time: {{nanoseconds_since_epoch: {START}}}
  message_count: 8
  topics_with_message_count:
  - topic_metadata: {{name: {TOPIC}, type: sensor_msgs/msg/JointState, serialization_format: cdr,
                      offered_qos_profiles: ''}}
    message_count: 8
  compression_format: ''
  compression_mode: ''
""")
    with BagRecording(old) as recording:
        assert_played(recording, messages)


@pytest.mark.parametrize('topics, topic, arm, wanted', [
    ({TOPIC: RIGHT, '/other': RIGHT}, None, None, (TOPIC, 'right')),
    ({TOPIC: LEFT, '/other': RIGHT}, None, 'left', (TOPIC, 'left')),
    ({TOPIC: ROBOT, '/other': RIGHT}, '/other', None, ('/other', 'right')),
    ({TOPIC: ROBOT}, None, 'left', (TOPIC, 'left')),
    ({TOPIC: GRIPPER, '/a': LEFT}, None, None, ('/a', 'left')),
    ({TOPIC: ROBOT}, TOPIC, 'right', (TOPIC, 'right')),
    ({'/joint_states': LEFT}, None, None, ('/joint_states', 'left')),
    ({'/joint_states': LEFT, '/gripper': GRIPPER}, None, None, ('/joint_states', 'left')),
    ({'/a': LEFT, '/b': RIGHT}, None, 'right', ('/b', 'right')),
    ({'/a': LEFT[:1]}, None, None, ('/a', 'left'))])
def test_topic_and_arm_are_found(make_bag, topics, topic, arm, wanted):
    messages = [message for name, joints in topics.items() for message in states(3, joints, name)]
    with BagRecording(make_bag(messages), topic, arm) as recording:
        assert (recording.topic, recording.arm) == wanted
        assert_played(recording, [message for message in messages if message[0] == wanted[0]])


def test_arm_is_found_after_many_gripper_messages(make_bag):
    grippers = states(900, GRIPPER)
    with BagRecording(make_bag(grippers + states(3, LEFT, start=START + 10**12))) as recording:
        assert recording.arm == 'left'

"""Reading of joint states from bags of every kind, and from MCAP files of other writers."""

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from recordings.joint_states import (assert_played, GRIPPER, KINDS, LEFT, RIGHT, ROBOT, START,
                                     states, TOPIC)

pytest.importorskip('rosbags', reason='reading bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.recordings.bag_files import type_store  # noqa: E402, I100
from baxter_dynamics_ros.recordings.bags import BagRecording  # noqa: E402
from baxter_dynamics_ros.recordings.recording import BagError  # noqa: E402
from mcap.reader import make_reader  # noqa: E402
from mcap.writer import IndexType, Writer  # noqa: E402
from rosbags.typesys import Stores  # noqa: E402
import zstandard  # noqa: E402

JOINT_STATE = 'sensor_msgs/msg/JointState'
STATES = states(40)


@pytest.mark.parametrize('kind, compression', [
    ('mcap', None), ('mcap', 'FILE'), ('mcap', 'MESSAGE'), ('mcap', 'STORAGE'),
    ('sqlite3', None), ('sqlite3', 'FILE'), ('sqlite3', 'MESSAGE'),
    ('ros1', None), ('ros1', 'LZ4'), ('ros1', 'BZ2')])
def test_plays_what_was_recorded(make_bag, kind, compression):
    others = [('/talk', received_ns, 'hello') for _, received_ns, _ in STATES]
    path = make_bag(others + STATES[::-1], kind, 'morning.run', compression)
    with BagRecording(path) as recording:
        assert (recording.path, recording.name) == (path, 'morning.run')
        assert (recording.topic, recording.arm) == (TOPIC, 'right')
        assert_played(recording, STATES)
        assert_played(recording, STATES)  # and again


@pytest.mark.parametrize('kind, ending, compression', [
    ('mcap', '.mcap', 'MESSAGE'), ('sqlite3', '.db3', None)])
def test_one_file_of_a_folder(make_bag, monkeypatch, kind, ending, compression):
    monkeypatch.chdir(make_bag(STATES, kind, compression=compression))
    with BagRecording(Path(f'run{ending}')) as recording:
        assert recording.name == 'run'
        assert_played(recording, STATES)


def test_a_file_of_a_bag_may_lack_the_topic(make_bag):
    path = make_bag(STATES, 'sqlite3')
    other = make_bag(states(3, topic='/other'), 'sqlite3', 'other')
    (other / 'other.db3').rename(path / 'other.db3')
    metadata = path / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace('- run.db3', '- run.db3\n  - other.db3'))
    with BagRecording(path) as recording:
        assert_played(recording, STATES)


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


@pytest.mark.parametrize('topics, topic, arm, wanted', [
    ({TOPIC: RIGHT, '/other': RIGHT}, None, None, (TOPIC, 'right')),
    ({TOPIC: LEFT, '/other': RIGHT}, None, 'left', (TOPIC, 'left')),
    ({TOPIC: ROBOT, '/other': RIGHT}, '/other', None, ('/other', 'right')),
    ({TOPIC: ROBOT}, TOPIC, 'left', (TOPIC, 'left')),
    ({TOPIC: GRIPPER, '/a': LEFT}, None, None, ('/a', 'left')),
    ({'/joint_states': LEFT, '/gripper': GRIPPER}, None, None, ('/joint_states', 'left')),
    ({'/a': LEFT, '/b': RIGHT}, None, 'right', ('/b', 'right')),
    ({'/a': LEFT[:1]}, None, None, ('/a', 'left'))])
def test_topic_and_arm_are_found(make_bag, topics, topic, arm, wanted):
    messages = [message for name, joints in topics.items() for message in states(3, joints, name)]
    with BagRecording(make_bag(messages), topic, arm) as recording:
        assert (recording.topic, recording.arm) == wanted
        assert_played(recording, [message for message in messages if message[0] == wanted[0]])


def test_arm_is_found_after_many_gripper_messages(make_bag):
    grippers = states(1100, GRIPPER)
    with BagRecording(make_bag(grippers + states(3, LEFT, start=START + 10**12))) as recording:
        assert recording.arm == 'left'


@pytest.fixture
def rewrite(make_bag, tmp_path):
    """Return a function that writes STATES again with other options of the MCAP writer."""
    def rewrite_(profile='ros2', other=None, change=bytes, order=1, encoding='cdr',
                 schema=(JOINT_STATE, 'ros2msg'), **options):
        source = make_bag(STATES) / 'run.mcap'
        path = tmp_path / 'other.mcap'
        with source.open('rb') as stream, path.open('wb') as target:
            writer = Writer(target, chunk_size=2000, **options)
            writer.start(profile)
            if other is not None:
                channel = writer.register_channel(
                    '/other', other, writer.register_schema('Other', f'{other}schema', b'\xff{}'))
                writer.add_message(channel, START, b'\x00\xff', START)
            messages = list(make_reader(stream).iter_messages())
            id_ = writer.register_schema(schema[0], schema[1], messages[0][0].data)
            channel = writer.register_channel(TOPIC, encoding, id_)
            for _, _, message in messages[::order]:
                writer.add_message(channel, message.log_time, change(message.data),
                                   message.publish_time)
            writer.finish()
        return path
    return rewrite_


def to_ros1(raw):
    """Return a joint state in the format of ROS 1."""
    message = type_store(Stores.ROS2_JAZZY).deserialize_cdr(raw, JOINT_STATE)
    store = type_store(Stores.ROS1_NOETIC)
    header = store.types['std_msgs/msg/Header'](7, message.header.stamp, 'base')
    return store.serialize_ros1(store.types[JOINT_STATE](
        header, message.name, message.position, message.velocity, message.effort), JOINT_STATE)


@pytest.mark.parametrize('options', [
    {'profile': ''}, {'profile': 'ros1'}, {'other': 'json'}, {'other': 'protobuf'},
    {'index_types': IndexType.CHUNK}, {'index_types': IndexType.NONE},
    {'repeat_channels': False}, {'repeat_schemas': False}, {'use_statistics': False},
    {'use_chunking': False}, {'use_summary_offsets': False, 'index_types': IndexType.MESSAGE},
    {'index_types': IndexType.NONE, 'repeat_channels': False, 'repeat_schemas': False,
     'use_statistics': False, 'use_summary_offsets': False},  # no summary at all
    {'order': -1}, {'order': -1, 'index_types': IndexType.NONE}, {'order': -1,
                                                                  'use_chunking': False},
    {'change': lambda raw: bytes(raw) + bytes(4)}, {'change': lambda raw: bytes(raw) + bytes(8)},
    {'profile': 'ros1', 'encoding': 'ros1', 'change': to_ros1,
     'schema': ('sensor_msgs/JointState', 'ros1msg')},
], ids=lambda options: ' '.join(key if callable(value) else f'{key}={value}'
                                for key, value in options.items()))
def test_mcap_files_of_other_writers_are_read(rewrite, options):
    with BagRecording(rewrite(**options)) as recording:
        assert_played(recording, STATES)
        assert_played(recording, STATES)


def test_compressed_mcap_files_are_read(make_bag, tmp_path):
    path = tmp_path / 'run.mcap.zstd'
    path.write_bytes(zstandard.compress((make_bag(STATES) / 'run.mcap').read_bytes()))
    with BagRecording(path) as recording:
        assert recording.name == 'run'
        assert_played(recording, STATES)
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(BagError, match=f'^{path}: cannot be read'):
        BagRecording(path).__enter__()


@pytest.mark.parametrize('options, reason', [
    ({'encoding': 'json'},
     rf'no joint states in .*; it has {TOPIC} \(sensor_msgs/msg/JointState, json\)'),
    ({'schema': ('foxglove.JointStates', 'protobuf'), 'encoding': 'protobuf'},
     rf'no joint states in .*; it has {TOPIC} \(foxglove.JointStates, protobuf\)$'),
    ({'change': lambda raw: bytes(raw)[:-20]}, f'{TOPIC}: the message received at .* is not a '),
])
def test_other_encodings_are_refused_with_the_reason(rewrite, options, reason):
    path = rewrite(**options)
    with pytest.raises(BagError, match=f'^{path}: {reason}') as caught:
        BagRecording(path).__enter__()
    assert 'mcap ' not in str(caught.value)


def test_shared_cases_are_read(shared):
    for path in sorted((shared / 'cases' / 'bags').glob('*.mcap')):
        with BagRecording(path, arm='right') as recording:
            arm = list(islice((s for s in recording if 'right_s0' in s.names), 300))
            assert 1190 <= recording.count
        assert 9.9e6 < np.median(np.diff([state.stamp_ns for state in arm])) < 10.1e6

"""MCAP files of writers other than rosbag2."""

from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

pytest.importorskip('rosbags', reason='reading bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.recordings.reader import BagRecording  # noqa: E402, I100
from baxter_dynamics_ros.recordings.recording import BagError  # noqa: E402
from mcap.reader import make_reader  # noqa: E402
from mcap.writer import IndexType, Writer  # noqa: E402
from rosbags.typesys import get_typestore, Stores  # noqa: E402
import zstandard  # noqa: E402

TOPIC, JOINT_STATE = '/robot/joint_states', 'sensor_msgs/msg/JointState'
START = 1_700_000_000_123_456_789  # [ns]
RIGHT = joint_names('right')
STATES = [(TOPIC, START + 10_000_000 * i, (START + 10_000_000 * i, RIGHT,
                                           *np.arange(21.0).reshape(3, 7) + i))
          for i in range(40)]


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
    message = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(raw, JOINT_STATE)
    store = get_typestore(Stores.ROS1_NOETIC)
    header = store.types['std_msgs/msg/Header'](7, message.header.stamp, 'base')
    return store.serialize_ros1(store.types[JOINT_STATE](
        header, message.name, message.position, message.velocity, message.effort), JOINT_STATE)


def assert_played(path):
    with BagRecording(path) as recording:
        for _ in range(2):
            states = list(recording)
            assert recording.count == len(states) == len(STATES)
            for state, (_, received_ns, (stamp_ns, names, *arrays)) in zip(states, STATES):
                assert (state.received_ns, state.stamp_ns) == (received_ns, stamp_ns)
                assert tuple(state.names) == names
                np.testing.assert_array_equal(state[2:5], arrays)


@pytest.mark.parametrize('options', [
    {'profile': ''}, {'profile': 'ros1'}, {'other': 'json'}, {'other': 'protobuf'},
    {'index_types': IndexType.CHUNK}, {'index_types': IndexType.NONE},
    {'repeat_channels': False}, {'repeat_schemas': False}, {'use_statistics': False},
    {'use_chunking': False}, {'use_summary_offsets': False, 'index_types': IndexType.MESSAGE},
    {'order': -1}, {'order': -1, 'index_types': IndexType.NONE}, {'order': -1,
                                                                  'use_chunking': False},
    {'change': lambda raw: bytes(raw) + bytes(4)}, {'change': lambda raw: bytes(raw) + bytes(8)},
    {'profile': 'ros1', 'encoding': 'ros1', 'change': to_ros1,
     'schema': ('sensor_msgs/JointState', 'ros1msg')},
], ids=lambda options: ' '.join(key if callable(value) else f'{key}={value}'
                                for key, value in options.items()))
def test_files_of_other_writers_are_read(rewrite, options):
    assert_played(rewrite(**options))


def test_compressed_files_are_read(make_bag, tmp_path):
    path = tmp_path / 'run.mcap.zstd'
    path.write_bytes(zstandard.compress((make_bag(STATES) / 'run.mcap').read_bytes()))
    assert_played(path)
    with BagRecording(path) as recording:
        assert recording.name == 'run'
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
            states = [state for state in recording if 'right_s0' in state.names]
        assert 1190 <= len(states) <= recording.count
        assert 9.9e6 < np.median(np.diff([state.stamp_ns for state in states])) < 10.1e6

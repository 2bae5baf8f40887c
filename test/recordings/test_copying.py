"""What a bag holds is taken along into a new one, as ROS 2 has it, or counted as skipped."""

import sqlite3

from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

pytest.importorskip('rosbags', reason='writing bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.recordings.bags import open_bag  # noqa: E402, I100
from baxter_dynamics_ros.recordings.writer import BagWriter  # noqa: E402
from rosbags.highlevel import AnyReader  # noqa: E402
from rosbags.interfaces import (  # noqa: E402
    Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime)
from rosbags.rosbag1 import Writer as Ros1Writer  # noqa: E402
from rosbags.rosbag2 import StoragePlugin, Writer as Ros2Writer  # noqa: E402
from rosbags.typesys import get_types_from_msg, get_typestore, Stores  # noqa: E402

JOINT_STATE = 'sensor_msgs/msg/JointState'
START = 1_700_000_000_123_456_789  # [ns]
RIGHT = joint_names('right')
STATE = (START, RIGHT, *np.arange(21.0).reshape(3, 7))
KINDS = ['mcap', 'sqlite3', 'ros1']


def contents(path):
    """Return all messages of a bag as rosbags reads them: (topic, time of receipt, message)."""
    with AnyReader([path]) as reader:
        return [(connection.topic, received_ns, reader.deserialize(raw, connection.msgtype))
                for connection, received_ns, raw in reader.messages()]


def copy(path, to, **options):
    """Copy a bag, all its messages; return the writer."""
    with open_bag(path) as recording, BagWriter(to, **options) as writer:
        for _ in recording.copied_to(writer):
            pass
    return writer


@pytest.mark.parametrize('kind', KINDS)
def test_copies_the_other_topics(make_bag, tmp_path, kind):
    messages = [('/talk', START, 'hello'), ('/joints', START + 1, STATE),
                ('/talk', START + 2, 'world'), ('/joints', START + 3, STATE)]
    with open_bag(make_bag(messages, kind)) as recording:
        with BagWriter(tmp_path / 'copy') as writer:
            for state in recording.copied_to(writer):
                writer.joint_state('/predicted', state.stamp_ns - 10, RIGHT, np.zeros(7),
                                   received_ns=state.received_ns)
    assert writer.skipped == {}
    copied = contents(tmp_path / 'copy')
    assert [(topic, received_ns) for topic, received_ns, _ in copied] == [
        ('/talk', START), ('/joints', START + 1), ('/predicted', START + 1), ('/talk', START + 2),
        ('/joints', START + 3), ('/predicted', START + 3)]
    assert [message.data for topic, _, message in copied if topic == '/talk'] == ['hello', 'world']
    for topic, _, message in copied:
        if topic == '/joints':
            assert message.header.stamp.nanosec == START % 10**9
            assert (message.header.frame_id, message.name) == ('base', list(RIGHT))
            np.testing.assert_array_equal(message.effort, STATE[4])


def test_reserved_topics_are_not_copied(make_bag, tmp_path):
    messages = [('/joints', START, STATE), ('/predicted', START, STATE),
                ('/predicted', START, STATE)]
    with open_bag(make_bag(messages), '/joints') as recording:
        with BagWriter(tmp_path / 'copy', reserved=['/predicted']) as writer:
            for _ in recording.copied_to(writer):
                writer.joint_state('/predicted', 7, RIGHT, np.zeros(7))
    assert writer.skipped == {'/predicted': 'the new bag has its own (2 messages)'}
    assert [(topic, received_ns) for topic, received_ns, _ in contents(tmp_path / 'copy')] == [
        ('/predicted', 7), ('/joints', START)]


def test_copied_and_written_topics_may_be_one(make_bag, tmp_path):
    with open_bag(make_bag([('/joints', START, STATE)])) as recording:
        with BagWriter(tmp_path / 'copy') as writer:
            for state in recording.copied_to(writer):
                writer.joint_state('/joints', *state)
    with open_bag(tmp_path / 'copy') as recording:
        assert len(list(recording)) == recording.count == 2


def test_keeps_how_topics_were_offered(tmp_path):
    forever = QosTime(9223372036, 854775807)
    qos = Qos(QosHistory.KEEP_LAST, 10, QosReliability.BEST_EFFORT, QosDurability.TRANSIENT_LOCAL,
              forever, forever, QosLiveliness.AUTOMATIC, forever, False)
    store = get_typestore(Stores.ROS2_JAZZY)
    with Ros2Writer(tmp_path / 'run', version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        add_joint_state(writer, store)
        text = writer.add_connection('/talk', 'std_msgs/msg/String', typestore=store,
                                     offered_qos_profiles=[qos, qos])
        message = store.types[text.msgtype]('hello')
        writer.write(text, START, store.serialize_cdr(message, text.msgtype))
    copy(tmp_path / 'run', tmp_path / 'copy')
    with AnyReader([tmp_path / 'copy']) as reader:
        profiles = {connection.topic: connection.ext.offered_qos_profiles
                    for connection in reader.connections}
    assert profiles == {'/joints': [], '/talk': [qos, qos]}


# A type of the robot's own, as ROS 1 bags define it, with types of its own and of ROS.
GRIPPER_DEFINITION = """
Header header
bool closed
string[] fingers
duration since
Finger[2] force
geometry_msgs/Point[] contacts
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
================================================================================
MSG: robot_msgs/Finger
char id
float64 force
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
"""


def add_joint_state(writer, store):
    """Record a joint state, for without one a bag is none of ours."""
    is_ros1 = isinstance(writer, Ros1Writer)
    stamp = store.types['builtin_interfaces/msg/Time'](1, 2)
    header = store.types['std_msgs/msg/Header'](*([0] if is_ros1 else []), stamp, '')
    message = store.types[JOINT_STATE](header, list(RIGHT), *np.zeros((3, 7)))
    raw = (store.serialize_ros1 if is_ros1 else store.serialize_cdr)(message, JOINT_STATE)
    writer.write(writer.add_connection('/joints', JOINT_STATE, typestore=store), START, raw)


def ros1_store():
    return get_typestore(Stores.ROS1_NOETIC)


def test_types_of_their_own_are_converted_from_ros1(tmp_path):
    name = 'robot_msgs/msg/Gripper'
    store = ros1_store()
    store.register({key: value for key, value in get_types_from_msg(
        GRIPPER_DEFINITION, name).items() if key.startswith('robot_msgs')})
    types = store.types
    message = types[name](
        types['std_msgs/msg/Header'](99, types['builtin_interfaces/msg/Time'](5, 6), 'hand'), True,
        ['l', 'right'], types['builtin_interfaces/msg/Duration'](7, 8),
        [types['robot_msgs/msg/Finger'](1, 0.5), types['robot_msgs/msg/Finger'](2, 1.5)],
        [types['geometry_msgs/msg/Point'](1.0, 2.0, 3.0)])
    with Ros1Writer(tmp_path / 'run.bag') as writer:
        add_joint_state(writer, store)
        for latching in (None, 1):
            connection = writer.add_connection(
                f'/gripper{latching or ""}', name, msgdef=GRIPPER_DEFINITION, md5sum='0' * 32,
                latching=latching)
            writer.write(connection, START, store.serialize_ros1(message, name))
    assert copy(tmp_path / 'run.bag', tmp_path / 'copy').skipped == {}
    copied = {topic: message for topic, _, message in contents(tmp_path / 'copy')}
    for topic in ('/gripper', '/gripper1'):
        found = copied[topic]
        assert not hasattr(found.header, 'seq')
        assert (found.header.stamp.sec, found.header.stamp.nanosec) == (5, 6)
        assert (found.header.frame_id, found.closed) == ('hand', True)
        assert found.fingers == ['l', 'right']
        assert (found.since.sec, found.since.nanosec) == (7, 8)
        assert [(finger.id, finger.force) for finger in found.force] == [(1, 0.5), (2, 1.5)]
        assert (found.contacts[0].x, found.contacts[0].z) == (1.0, 3.0)
    with AnyReader([tmp_path / 'copy']) as reader:
        durabilities = {connection.topic: [qos.durability for qos in
                                           connection.ext.offered_qos_profiles]
                        for connection in reader.connections}
    assert durabilities == {'/joints': [], '/gripper': [],
                            '/gripper1': [QosDurability.TRANSIENT_LOCAL]}


def test_names_of_fields_are_those_of_ros2(tmp_path):
    """ROS 1's CameraInfo has D, K, R, P where ROS 2's has d, k, r, p: the same bytes."""
    name = 'sensor_msgs/msg/CameraInfo'
    definition, md5sum = ros1_store().generate_msgdef(name)
    header = bytes(12) + b'\4\0\0\0hand'
    raw = header + bytes(12) + b'\1\0\0\0' + np.array([0.25]).tobytes() + bytes(30 * 8 + 25)
    with Ros1Writer(tmp_path / 'run.bag') as writer:
        add_joint_state(writer, ros1_store())
        connection = writer.add_connection('/camera', name, msgdef=definition, md5sum=md5sum)
        writer.write(connection, START, raw)
    assert copy(tmp_path / 'run.bag', tmp_path / 'copy').skipped == {}
    (camera,) = [message for topic, _, message in contents(tmp_path / 'copy')
                 if topic == '/camera']
    assert (camera.header.frame_id, list(camera.d)) == ('hand', [0.25])


def test_says_what_cannot_be_copied_from_ros1(tmp_path):
    definitions = {
        '/marker': ('visualization_msgs/msg/Marker',
                    ros1_store().generate_msgdef('visualization_msgs/msg/Marker')[0]),
        '/riddle': ('robot_msgs/msg/Riddle', 'this is no definition'),
        '/finger': ('robot_msgs/msg/Finger', 'float64 force\n'),
        '/other_finger': ('robot_msgs/msg/Finger', 'float32 force\n'),
        '/broken': ('robot_msgs/msg/Long', 'float64[3] values\n')}
    with Ros1Writer(tmp_path / 'run.bag') as writer:
        add_joint_state(writer, ros1_store())
        for i, (topic, (name, definition)) in enumerate(definitions.items()):
            connection = writer.add_connection(topic, name, msgdef=definition, md5sum='0' * 32)
            for k in range(i + 1):
                writer.write(connection, START + 10 * i + k, bytes(8))
    skipped = copy(tmp_path / 'run.bag', tmp_path / 'copy').skipped
    assert skipped.pop('/broken').startswith('broken messages: ')
    assert skipped == {
        '/marker': 'its type visualization_msgs/msg/Marker has other fields in ROS 2 (1 messages)',
        '/riddle': 'the definition of its type robot_msgs/msg/Riddle cannot be read '
                   '(TypesysError) (2 messages)',
        '/other_finger': 'its type robot_msgs/msg/Finger, or one it is made of, is defined '
                         'otherwise by another topic (4 messages)'}
    assert {topic for topic, _, _ in contents(tmp_path / 'copy')} == {'/joints', '/finger'}


def test_types_without_definition(make_bag, tmp_path):
    """As in ROS 2 bags of old: ROS's own types are known, others are not."""
    messages = [('/joints', START, STATE), ('/talk', START, 'hello'), ('/own', START, 'hello')]
    path = make_bag(messages, 'sqlite3')
    with sqlite3.connect(path / 'run.db3') as database:
        database.execute('DELETE FROM message_definitions')
        database.execute("UPDATE topics SET type = 'robot_msgs/msg/Own' WHERE name = '/own'")
    database.close()
    writer = copy(path / 'run.db3', tmp_path / 'copy')
    assert writer.skipped == {
        '/own': 'the bag does not define its type robot_msgs/msg/Own (1 messages)'}
    assert {topic for topic, _, _ in contents(tmp_path / 'copy')} == {'/joints', '/talk'}


IDL = 'module robot_msgs { module msg { struct Finger { double force; }; }; };'


@pytest.mark.parametrize('definition', [IDL, f'{80 * "="}\nIDL: robot_msgs/msg/Finger\n{IDL}'])
def test_types_defined_by_idl(tmp_path, definition):
    name = 'robot_msgs/msg/Finger'
    with Ros2Writer(tmp_path / 'run', version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        add_joint_state(writer, get_typestore(Stores.ROS2_JAZZY))
        connection = writer.add_connection('/finger', name, msgdef=definition, rihs01='RIHS01_')
        writer.write(connection, START, b'\0\1\0\0' + np.array([2.5]).tobytes())
    file = tmp_path / 'run' / 'run.mcap'
    if not definition.startswith('='):  # which rosbags' writer takes for the other language
        file.write_bytes(file.read_bytes().replace(
            name.encode() + b'\7\0\0\0ros2msg', name.encode() + b'\7\0\0\0ros2idl'))
    assert copy(tmp_path / 'run', tmp_path / 'copy').skipped == {}
    (force,) = [message.force for topic, _, message in contents(tmp_path / 'copy')
                if topic == '/finger']
    assert force == 2.5


def test_messages_in_another_encoding(make_bag, tmp_path):
    path = make_bag([('/joints', START, STATE), ('/talk', START, 'hello')])
    file = path / 'run.mcap'
    data = file.read_bytes()
    assert data.count(b'/talk\3\0\0\0cdr') == 2
    file.write_bytes(data.replace(b'/talk\3\0\0\0cdr', b'/talk\3\0\0\0xyz'))
    assert copy(file, tmp_path / 'copy').skipped == {
        '/talk': 'its messages are xyz, not CDR (1 messages)'}

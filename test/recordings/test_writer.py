"""Bags of joint states are written whole, or not at all."""

from pathlib import Path
import resource

from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

pytest.importorskip('rosbags', reason='writing bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.recordings.bags import open_bag  # noqa: E402, I100
from baxter_dynamics_ros.recordings.diagnosis import BagError  # noqa: E402
from baxter_dynamics_ros.recordings.writer import BagWriter  # noqa: E402
from rosbags.highlevel import AnyReader  # noqa: E402

JOINT_STATE = 'sensor_msgs/msg/JointState'
START = 1_700_000_000_123_456_789  # [ns]
RIGHT = joint_names('right')
STATE = (START, RIGHT, *np.arange(21.0).reshape(3, 7))


def contents(path):
    """Return all messages of a bag as rosbags reads them: (topic, time of receipt, message)."""
    with AnyReader([path]) as reader:
        return [(connection.topic, received_ns, reader.deserialize(raw, connection.msgtype))
                for connection, received_ns, raw in reader.messages()]


@pytest.mark.parametrize('names, position, velocity, effort', [
    (RIGHT, np.arange(7.0), np.arange(7.0) + 10, np.arange(7.0) + 20),
    (RIGHT, np.arange(7.0), (), np.arange(7.0)),
    (RIGHT, [0.0, 1, 2, 3, 4, 5, 6], [], []),
    (['a', 'bc', 'def', 'ghij', 'klmno', 'é', ''], np.arange(14.0)[::2], (), (np.nan,)),
    ((), (), (), ()),
    ((), (), (), (1.0, 2.0))])
def test_joint_states_come_back(tmp_path, names, position, velocity, effort):
    with BagWriter(tmp_path / 'new') as writer:
        writer.joint_state('/a', START, names, position, velocity, effort)
        writer.joint_state('/b', START, names, position, velocity, effort, received_ns=START + 5)
    for (topic, received_ns, message), wanted in zip(
            contents(tmp_path / 'new'), [('/a', START), ('/b', START + 5)], strict=True):
        assert (topic, received_ns) == wanted
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == START
        assert (message.header.frame_id, message.name) == ('', list(names))
        for field, values in zip(('position', 'velocity', 'effort'),
                                 (position, velocity, effort)):
            np.testing.assert_array_equal(getattr(message, field), values)


def test_it_is_a_bag_for_our_reader(tmp_path):
    with BagWriter(tmp_path / 'new') as writer:
        for i in range(3):
            writer.joint_state('/predicted', START + i, *STATE[1:])
    with open_bag(tmp_path / 'new') as recording:
        assert (recording.topic, recording.arm, recording.count) == ('/predicted', 'right', 3)
        assert [state.stamp_ns for state in recording] == [START, START + 1, START + 2]


def test_nothing_is_there_before_the_end(tmp_path):
    with BagWriter(tmp_path / 'new') as writer:
        writer.joint_state('/a', *STATE)
        assert not (tmp_path / 'new').exists()
    assert [path.name for path in tmp_path.iterdir()] == ['new']
    assert sorted(path.name for path in (tmp_path / 'new').iterdir()) == ['metadata.yaml',
                                                                          'new.mcap']


@pytest.mark.parametrize('exception', [RuntimeError, KeyboardInterrupt, BagError])
def test_nothing_is_left_after_an_exception(tmp_path, exception):
    with pytest.raises(exception):
        with BagWriter(tmp_path / 'new') as writer:
            writer.joint_state('/a', *STATE)
            raise exception
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('make', [Path.mkdir, Path.touch, lambda path: path.symlink_to('nowhere')],
                         ids=['folder', 'file', 'dangling link'])
@pytest.mark.parametrize('meanwhile', [False, True])
def test_what_exists_stays(tmp_path, make, meanwhile):
    path = tmp_path / 'new'
    with pytest.raises(BagError, match=f'^{path}: exists; name a new folder, or remove it first$'):
        if not meanwhile:
            make(path)
        with BagWriter(path) as writer:
            writer.joint_state('/a', *STATE)
            make(path)
    assert [left.name for left in tmp_path.iterdir()] == ['new']
    assert not (path / 'metadata.yaml').exists()


def test_parent_must_exist(tmp_path):
    path = tmp_path / 'none' / 'new'
    with pytest.raises(BagError, match=f'^{path}: there is no folder {path.parent} to write it'):
        BagWriter(path)


def test_disk_full(tmp_path):
    """As a limit to the size of files has it, to which writing fails alike."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    with pytest.raises(BagError, match=f'^{tmp_path / "new"}: cannot be written .*large'):
        with BagWriter(tmp_path / 'new') as writer:
            resource.setrlimit(resource.RLIMIT_FSIZE, (3_000_000, hard))  # bytes
            try:
                for _ in range(20_000):
                    writer.joint_state('/a', *STATE)
            finally:
                resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('stamp_ns, received_ns', [
    (2**31 * 10**9, 1), (START, -1), (START, 2**64)])
def test_impossible_times(tmp_path, stamp_ns, received_ns):
    with pytest.raises(BagError, match=f'^{tmp_path / "new"}: .*'):
        with BagWriter(tmp_path / 'new') as writer:
            writer.joint_state('/a', stamp_ns, *STATE[1:], received_ns=received_ns)

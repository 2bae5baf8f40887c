"""Bags appear completely or not at all."""

from pathlib import Path
import resource

from baxter_dynamics_ros.model import BaxterDynamicsError
import numpy as np
import pytest
from recordings.joint_states import RIGHT, START

pytest.importorskip('rosbags', reason='writing bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.recordings.bags import new_bag  # noqa: E402, I100

STATE = (START, RIGHT, *np.arange(21.0).reshape(3, 7))


@pytest.mark.parametrize('names, position, velocity, effort', [
    (RIGHT, np.arange(7.0), (), np.arange(7.0) + 20),
    (['a', 'bc', 'def', 'ghij', 'klmno', 'é', ''], np.arange(14.0)[::2], [], (np.nan,)),
    ((), (), (), (1.0, 2.0))])
def test_joint_states_round_trip(tmp_path, read_bag, names, position, velocity, effort):
    with new_bag(tmp_path / 'new') as writer:
        writer.joint_state('/a', START, names, position, velocity, effort)
        writer.joint_state('/b', START, names, position, velocity, effort, START + 5, 'base')
        assert not (tmp_path / 'new').exists()
    assert [path.name for path in tmp_path.iterdir()] == ['new']
    found = read_bag(tmp_path / 'new')
    assert [*found] == ['/a', '/b']
    for ((received, message),), wanted in zip(
            found.values(), [(START, ''), (START + 5, 'base')], strict=True):
        assert (received, message.header.frame_id) == wanted
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == START
        assert message.name == list(names)
        for field, values in zip(('position', 'velocity', 'effort'), (position, velocity, effort)):
            np.testing.assert_array_equal(getattr(message, field), values)


@pytest.mark.parametrize('make', [Path.mkdir, Path.touch, lambda path: path.symlink_to('nowhere')],
                         ids=['folder', 'file', 'dangling link'])
@pytest.mark.parametrize('meanwhile', [False, True])
def test_existing_paths_are_refused(tmp_path, make, meanwhile):
    path = tmp_path / 'new'
    with pytest.raises(BaxterDynamicsError, match=f'^{path}: exists; choose a new folder'):
        if not meanwhile:
            make(path)
        with new_bag(path) as writer:
            writer.joint_state('/a', *STATE)
            make(path)
    assert [left.name for left in tmp_path.iterdir()] == ['new']
    assert not (path / 'metadata.yaml').exists()
    with pytest.raises(BaxterDynamicsError, match=f'none/new: no folder {tmp_path}/none$'):
        new_bag(tmp_path / 'none' / 'new').__enter__()


def _fill_disk(writer):
    """Run into a limit on the size of files, which fails a write like a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (500_000, hard))  # [bytes]
    try:
        for _ in range(6_000):
            writer.joint_state('/a', *STATE)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize('write, reason', [
    (_fill_disk, 'cannot be written .*large'),
    (lambda writer: writer.joint_state('/a', 2**31 * 10**9, *STATE[1:]), '/a: cannot be written'),
    (lambda writer: writer.joint_state('/a', *STATE, received_ns=-1), '/a: cannot be written'),
], ids=['full disk', 'stamp', 'time of recording'])
def test_failures_leave_nothing(tmp_path, write, reason):
    with pytest.raises(BaxterDynamicsError, match=f'^{tmp_path / "new"}: {reason}'):
        with new_bag(tmp_path / 'new') as writer:
            writer.joint_state('/b', *STATE)
            write(writer)
    assert list(tmp_path.iterdir()) == []

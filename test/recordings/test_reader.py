"""Recordings of all kinds side by side, and those in .npz files."""

import re

from baxter_dynamics_ros.model.joints import joint_names, JOINTS
import numpy as np
import pytest

pytest.importorskip('rosbags', reason='reading bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.recordings.diagnosis import BagError  # noqa: E402, I100
from baxter_dynamics_ros.recordings.reader import open_recordings  # noqa: E402
from baxter_dynamics_ros.recordings.writer import BagWriter  # noqa: E402

RIGHT, LEFT = joint_names('right'), joint_names('left')


@pytest.fixture
def contents(rng):
    """Return what an .npz file with three recordings of 5, 0 and 3 rows holds."""
    return {'joint_names': np.array(LEFT), 'period': 0.01, 'recording': np.repeat([0, 2], [5, 3]),
            'recording_names': np.array(['spiral', 'nothing', 'random']),
            **{key: rng.normal(size=(8, 7)) for key in ('position', 'velocity', 'effort')}}


@pytest.fixture
def save(tmp_path):
    """Return a function that saves arrays as an .npz file, and its path."""
    def save(contents):
        np.savez(tmp_path / 'arm.npz', **contents)
        return tmp_path / 'arm.npz'
    return save


def test_recordings_of_a_file(contents, save):
    path = save(contents)
    recordings = open_recordings([path])
    assert [recording.name for recording in recordings] == ['spiral', 'nothing', 'random']
    for recording, rows in zip(recordings, [slice(0, 5), slice(0, 0), slice(5, 8)]):
        with recording:
            assert (recording.path, recording.arm) == (path, 'left')
            assert recording.topic == '/robot/joint_states'
            played = list(recording)
            assert recording.count == len(played) == rows.stop - rows.start
        assert [state.stamp_ns for state in played] == [
            10**18 + 10_000_000 * i for i in range(len(played))]
        for i, key in enumerate(('position', 'velocity', 'effort'), 2):
            np.testing.assert_array_equal(
                np.reshape([state[i] for state in played], (-1, 7)), contents[key][rows])
        for state in played:
            assert (tuple(state.names), state.received_ns) == (LEFT, state.stamp_ns)


@pytest.mark.parametrize('arm, wanted', [(None, RIGHT), ('right', RIGHT), ('left', LEFT)])
def test_names_without_a_side(contents, save, arm, wanted):
    path = save(contents | {'joint_names': np.array(JOINTS)})
    with open_recordings([path], arm=arm)[0] as recording:
        assert recording.arm == wanted[0].partition('_')[0]
        assert tuple(next(iter(recording)).names) == wanted


@pytest.mark.parametrize('changes, pattern', [
    ({'period': 0.0}, 'period must be a positive number of seconds, is 0.0'),
    ({'period': np.nan}, 'period must be a positive number of seconds, is nan'),
    ({'period': [0.1, 0.1]}, 'period must be a positive number'),
    ({'effort': None}, 'cannot be read as .npz; is it complete?'),
    ({'effort': np.zeros((7, 7))}, r'effort must have 8 rows .* of 7 numbers .*\(7, 7\)$'),
    ({'position': np.zeros((8, 6))}, 'position must have 8 rows'),
    ({'velocity': np.full((8, 7), 'fast')}, 'velocity must have 8 rows .* of 7 numbers .*, is <U'),
    ({'joint_names': RIGHT[:6] + LEFT[:1]}, "spiral holds both arms' joints: say --arm right"),
    ({'joint_names': list('abcdefg')}, 'spiral has no joints of an arm, only a, b, c, d, '),
])
def test_says_what_is_wrong(contents, save, changes, pattern):
    path = save(contents | changes)
    assert_refused(path, pattern)


def test_wrong_arm(contents, save):
    assert_refused(save(contents), 'spiral has no joints of the right arm, only left_e0, ',
                   arm='right')


def test_missing_keys(contents, save):
    del contents['effort'], contents['period']
    assert_refused(save(contents), 'lacks period, effort; a file of recordings holds joint_')


@pytest.mark.parametrize('content', [b'', b'hello world', b'PK\x03\x04' + 50 * b'x'])
def test_not_an_npz_file(tmp_path, content):
    path = tmp_path / 'arm.npz'
    path.write_bytes(content)
    assert_refused(path, 'cannot be read as .npz; is it complete?')


def test_array_instead_of_a_file_of_arrays(tmp_path):
    with open(tmp_path / 'arm.npz', 'wb') as file:
        np.save(file, np.zeros(3))
    assert_refused(tmp_path / 'arm.npz', 'cannot be read as .npz')


def test_cut_npz(contents, save):
    path = save(contents)
    path.write_bytes(path.read_bytes()[:-100])
    assert_refused(path, 'cannot be read as .npz; is it complete?')


def test_bags_and_arrays_in_the_order_given(make_bag, contents, save):
    bag = make_bag([('/a', 10**18, (10**18, RIGHT, *np.zeros((3, 7))))], 'ros1', 'first')
    recordings = open_recordings([str(bag), save(contents)], '/a')
    assert [recording.name for recording in recordings] == ['first', 'spiral', 'nothing', 'random']
    with recordings[0] as recording:
        assert (recording.topic, recording.arm, recording.count) == ('/a', 'right', 1)


def test_missing_paths_show_before_work_begins(make_bag, tmp_path):
    bag = make_bag([('/a', 10**18, (10**18, RIGHT, *np.zeros((3, 7))))])
    for name in ('none', 'none.npz'):
        with pytest.raises(BagError, match=f'^{tmp_path / name}: there is no such file'):
            open_recordings([bag, tmp_path / name])


def test_recording_without_a_bag_is_written_into_one(contents, save, tmp_path):
    with open_recordings([save(contents)])[0] as recording:
        with BagWriter(tmp_path / 'copy') as writer:
            played = list(recording.copied_to(writer))
    with open_recordings([tmp_path / 'copy'])[0] as copy:
        assert copy.arm == 'left'
        for state, wanted in zip(copy, played, strict=True):
            assert (state.stamp_ns, state.received_ns) == (wanted.stamp_ns, wanted.received_ns)
            assert tuple(state.names) == tuple(wanted.names)
            np.testing.assert_array_equal(state[2:5], wanted[2:5])


def test_recordings_of_real_arms(recordings):
    paths = sorted(recordings.glob('*.npz'))
    found = open_recordings(paths)
    assert len(found) == 13
    assert sum(recording.count for recording in found) == 67_881 + 15_000
    for recording in (found[0], found[-1]):
        with recording:
            for i, state in enumerate(recording):
                pass
            assert i + 1 == recording.count
            assert state.stamp_ns > 10**18


def assert_refused(path, pattern, arm=None):
    with pytest.raises(BagError, match=f'^{re.escape(str(path))}: {pattern}') as caught:
        for recording in open_recordings([path], arm=arm):
            with recording:
                pass
    assert '\n' not in str(caught.value)

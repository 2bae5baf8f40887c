"""Recordings in .npz and .csv files, alone and beside bags."""

from baxter_dynamics_ros.model.joints import JOINTS
import numpy as np
import pytest
from recordings.joint_states import assert_played, LEFT, RIGHT

pytest.importorskip('rosbags', reason='reading bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.recordings.bags import open_recordings  # noqa: E402, I100
from baxter_dynamics_ros.recordings.recording import BagError  # noqa: E402

HEADER, BOTH = (','.join(['time', *(f'{joint}_{key}' for joint in joints
                                    for key in ('position', 'velocity', 'effort'))])
                for joints in (JOINTS, LEFT + RIGHT))


@pytest.fixture
def contents(rng):
    """Return what an .npz file with three recordings of 5, 0 and 3 rows holds."""
    return {'joint_names': np.array(LEFT), 'period': 0.01, 'recording': np.repeat([0, 2], [5, 3]),
            'recording_names': np.array(['spiral', 'nothing', 'random']), 'note': np.array(None),
            **{key: rng.normal(size=(8, 7)) for key in ('position', 'velocity', 'effort')}}


@pytest.fixture
def save(tmp_path):
    """Return a function that saves arrays as an .npz file, and its path."""
    def save(contents):
        np.savez(tmp_path / 'arm.npz', **contents)
        return tmp_path / 'arm.npz'
    return save


def assert_rows(recording, contents, rows, stamps_ns):
    """Assert that an open recording yields these rows of the arrays, at these stamps."""
    arrays = (contents[key][rows] for key in ('position', 'velocity', 'effort'))
    assert_played(recording, [('', stamp, (stamp, LEFT, *row))
                              for stamp, *row in zip(stamps_ns, *arrays, strict=True)])


def test_npz_with_several_recordings(contents, save):
    recordings = open_recordings([save(contents)])
    assert [recording.name for recording in recordings] == ['spiral', 'nothing', 'random']
    for recording, rows in zip(recordings, [slice(0, 5), slice(0, 0), slice(5, 8)]):
        with recording:
            assert (recording.arm, recording.topic) == ('left', '/robot/joint_states')
            assert_rows(recording, contents, rows, 10**18 + 10_000_000 * np.arange(
                rows.stop - rows.start))


def test_npz_with_stamps_and_a_single_recording(contents, save):
    for key in ('period', 'recording', 'recording_names'):
        del contents[key]
    stamps = 1_700_000_000.25 + 0.01 * np.arange(8)
    contents['names'] = contents.pop('joint_names')
    with open_recordings([save({**contents, 'stamp': stamps})])[0] as recording:
        assert recording.name == 'arm'
        whole = np.array([1_700_000_000_250_000_000 + 10_000_000 * i for i in range(8)])
        found = [state.stamp_ns for state in recording]
        assert np.abs(found - whole).max() < 1000  # the resolution of such a double [ns]
        assert_rows(recording, contents, slice(0, 8), found)
    (small,) = open_recordings([save({**contents, 'stamp': np.arange(8, dtype=np.uint8)})])
    assert small.stamps_ns.tolist() == [1, *(10**9 * i for i in range(1, 8))]  # 0: unstamped


@pytest.mark.parametrize('header, joint_prefix, arm, wanted', [
    ('', '', None, RIGHT), ('', 'a/', 'left', LEFT), ('left_', '', None, LEFT),
    ('left_', 'a/', None, LEFT), ('a/left_', 'a/', None, LEFT)])
def test_csv(contents, tmp_path, header, joint_prefix, arm, wanted):
    columns = {'time': np.arange(8) * 0.02, 'note': np.full(8, 'wide'), **{
        f'{header}{joint}_{key}': contents[key][:, i] for key in ('effort', 'position', 'velocity')
        for i, joint in enumerate(JOINTS)}}
    rows = zip(*(column.tolist() for column in columns.values()))
    (tmp_path / 'run.csv').write_text('\ufeff' + ', '.join(columns) + '\r\n' + ''.join(
        ','.join(map(repr, row)) + '\r\n' for row in rows))
    (recording,) = open_recordings([tmp_path / 'run.csv'], arm=arm, prefix=joint_prefix)
    with recording:
        assert (recording.name, recording.arm) == ('run', wanted[0].partition('_')[0])
        states = list(recording)
    assert [state.stamp_ns for state in states[1:]] == [20_000_000 * i for i in range(1, 8)]
    assert tuple(states[0].names) == tuple(joint_prefix + name for name in wanted)
    np.testing.assert_array_equal([state.effort for state in states], contents['effort'])


@pytest.mark.parametrize('text, reason', [
    ('', 'expected columns time, s0_position'), ('time,s0_position\n1,2\n', 'expected columns'),
    ('\0', 'expected columns|cannot be read'),
    (f'{HEADER}\n\n# none\n', 'has no rows'), (f'{HEADER}\n1,x\n', 'cannot be read .could not'),
    (f'{BOTH}\n0{42 * ",0"}', "run has both arms' joints: choose --arm right or --arm left")])
def test_csv_faults(tmp_path, text, reason):
    (tmp_path / 'run.csv').write_text(text)
    assert_refused(tmp_path / 'run.csv', reason)


def assert_refused(path, reason, **options):
    with pytest.raises(BagError, match=rf'^{path}: ({reason})') as caught:
        for recording in open_recordings([path], **options):
            with recording:
                list(recording)
    assert '\n' not in str(caught.value) and len(str(caught.value)) < 500


@pytest.mark.parametrize('changes, reason', [
    ({'period': 0.0}, 'period must be a number of seconds up to 1, is 0.0'),
    ({'period': 1.5}, 'period must be a number of seconds up to 1, is 1.5'),
    ({'period': np.nan}, 'period must be a number of seconds up to 1, is nan'),
    ({'stamp': 0.01 * np.arange(7)}, r'stamp must have 8 numbers .*, is float64 \(7,\)$'),
    ({'effort': None}, 'cannot be read .*; is it complete?'),
    ({'effort': np.zeros((7, 7))}, r'effort must have 8 rows of 7 numbers .*\(7, 7\)$'),
    ({'joint_names': RIGHT[:6] + LEFT[:1]}, "spiral has both arms' joints: choose --arm right"),
    ({'joint_names': list('abcdefg')}, 'spiral has no joints of an arm, only a, b, c, d, '),
    ({'recording': np.repeat([0, 3, -1], [5, 2, 1])},
     '3 of 8 rows belong to recording 3, but recording_names has 3 names'),
    ({'recording': np.zeros(8)}, 'recording must have 8 integers, is float64'),
    ({'stamp': np.full(8, np.inf)}, 'stamp must have 8 numbers of seconds'),
], ids=str)
def test_npz_faults(contents, save, changes, reason):
    assert_refused(save(contents | changes), reason)


def test_missing_arrays_and_wrong_arm(contents, save):
    assert_refused(save(contents), 'spiral has no joints of the right arm, only', arm='right')
    del contents['effort'], contents['period']
    assert_refused(save(contents), 'lacks effort, period or stamp; it has joint_names, recording')


@pytest.mark.parametrize('content', [b'', b'hello', b'PK\x03\x04' + 50 * b'x', 'array', 'cut',
                                     'method'])
def test_other_files_named_npz(tmp_path, contents, save, content):
    path = save(contents)
    if content == 'cut':
        path.write_bytes(path.read_bytes()[:-100])
    elif content == 'array':
        with path.open('wb') as file:
            np.save(file, np.zeros(3))
    elif content == 'method':  # of compression, which zipfile does not know
        data = path.read_bytes()
        at = data.rindex(b'PK\1\2') + 10
        path.write_bytes(data[:at] + b'\x63' + data[at + 1:])
    else:
        path.write_bytes(content)
    assert_refused(path, 'cannot be read .*; is it complete?')


def test_bags_and_arrays_in_the_order_given(make_bag, contents, save):
    bag = make_bag([('/a', 10**18, (10**18, RIGHT, *np.zeros((3, 7))))], 'ros1', 'first')
    recordings = open_recordings([str(bag), save(contents)], '/a')
    assert [recording.name for recording in recordings] == ['first', 'spiral', 'nothing', 'random']
    with recordings[0] as recording:
        assert (recording.topic, recording.arm, recording.count) == ('/a', 'right', 1)


def test_paths_are_checked_before_work_begins(make_bag, tmp_path):
    bag = make_bag([('/a', 10**18, (10**18, RIGHT, *np.zeros((3, 7))))])
    for path, reason in {tmp_path / 'none': 'no such file', tmp_path / 'none.npz': 'no such file',
                         '/dev/zero': 'is neither a file nor a folder'}.items():
        with pytest.raises(BagError, match=f'^{path}: {reason}'):
            open_recordings([bag, path])

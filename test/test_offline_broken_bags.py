"""Bags that are broken, or hold something else: one line that says what is wrong."""

import os
import re
import shutil
import sqlite3
import struct

from baxter_dynamics_ros.core.joints import joint_names
import numpy as np
import pytest

pytest.importorskip('rosbags', reason='reading bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.offline.bags import open_bag  # noqa: E402, I100
from baxter_dynamics_ros.offline.diagnosis import BagError  # noqa: E402

TOPIC = '/robot/joint_states'
START = 1_700_000_000_123_456_789  # [ns]
RIGHT, LEFT = joint_names('right'), joint_names('left')
ROBOT = ('head_nod', 'head_pan', *LEFT, *RIGHT, 'torso_t0')
GRIPPER = ('r_gripper_l_finger_joint', 'r_gripper_r_finger_joint')
KINDS = ['mcap', 'sqlite3', 'ros1']


def states(n, names=RIGHT, topic=TOPIC):
    """Return n joint states, 10 ms apart."""
    values = np.arange(3.0 * len(names)).reshape(3, -1)
    return [(topic, START + i * 10_000_000, (START + i * 10_000_000, names, *values))
            for i in range(n)]


def remove_summary(file):
    """Make an MCAP file as a recorder does that writes no index."""
    data = file.read_bytes()
    (summary,) = struct.unpack('<Q', data[-28:-20])
    file.write_bytes(data[:summary] + b'\x02' + struct.pack('<QQQI', 20, 0, 0, 0) + data[-8:])


def cut(path, fraction=0.6):
    os.truncate(path, int(path.stat().st_size * fraction))
    return path


def unindexed_ros1(path):
    data = bytearray(path.read_bytes())
    at = data.index(b'index_pos=') + len('index_pos=')
    data[at:at + 8] = bytes(8)
    path.write_bytes(data)
    return path


def missing_file(path):
    (path / 'run.mcap').unlink()
    return path


def missing_metadata(path):
    (path / 'metadata.yaml').unlink()
    return path


def other_metadata(path, text='{}'):
    (path / 'metadata.yaml').write_text(text)
    return path


def too_many_promised(path):
    file = path / 'metadata.yaml'
    file.write_text(file.read_text().replace('message_count: 20', 'message_count: 30'))
    return path


def unmerged(path):
    """Return a bag whose last message SQLite has in another file, as when a recorder is killed."""
    database = sqlite3.connect(path / 'run.db3')
    database.execute('PRAGMA journal_mode=WAL')
    database.execute('INSERT INTO messages SELECT 1000, topic_id, timestamp, data FROM messages '
                     'WHERE id = 1')
    database.commit()
    left = path.with_name('left')
    shutil.copytree(path, left)
    database.close()
    return left


def unsorted(make):
    path = make(states(20)[::-1]) / 'run.mcap'
    remove_summary(path)
    return path


def undecodable(make):
    path = make([(TOPIC, START, 'no joint state'), *states(20)], 'sqlite3')
    with sqlite3.connect(path / 'run.db3') as database:
        database.execute("UPDATE messages SET data = x'0001000000' WHERE id = 12")
    database.close()
    return path


def text(path, content='hello world\n' * 100):
    path.write_text(content)
    return path


def inner(path, folder):
    folder.mkdir()
    path.rename(folder / path.name)
    return folder


# What is wrong -> how to make it from (make_bag, tmp_path), and what the line says behind the path
# that is given, as a pattern.
BROKEN = {
    'missing': (lambda make, tmp: tmp / 'none', 'there is no such file or folder'),
    'below a file': (lambda make, tmp: text(tmp / 'x.bag') / 'y', 'there is no such file'),
    'empty mcap': (lambda make, tmp: text(tmp / 'x.mcap', ''), 'is empty$'),
    'empty db3': (lambda make, tmp: text(tmp / 'x.db3', ''), 'is empty$'),
    'empty bag': (lambda make, tmp: text(tmp / 'x.bag', ''), 'is empty$'),
    'text': (lambda make, tmp: text(tmp / 'x.txt'), 'is not a bag: give a folder of rosbag2'),
    'text mcap': (lambda make, tmp: text(tmp / 'x.mcap'), 'is not an MCAP file'),
    'text db3': (lambda make, tmp: text(tmp / 'x.db3'), 'is not an SQLite file'),
    'text bag': (lambda make, tmp: text(tmp / 'x.bag'), 'is not a ROS 1 bag of version 2.0'),
    'old bag': (lambda make, tmp: text(tmp / 'x.bag', '#ROSBAG V1.2\n'), 'is not a ROS 1 bag of'),
    'empty folder': (lambda make, tmp: inner(text(tmp / 'x'), tmp / 'y'),
                     'is not a bag, for it has no metadata.yaml$'),
    'folder of bags': (lambda make, tmp: inner(make(states(3)), tmp / 'y'),
                       r'is not a bag, .*; give one of the bags in it: run$'),
    'metadata itself': (lambda make, tmp: make(states(3)) / 'metadata.yaml',
                        'is a part of a bag: give its folder, .*/run$'),
    'no metadata': (lambda make, tmp: missing_metadata(make(states(3))),
                    'has no metadata.yaml .*: `ros2 bag reindex -s mcap .*/run` makes it$'),
    'no metadata db3': (lambda make, tmp: missing_metadata(make(states(3), 'sqlite3')),
                        'has no metadata.yaml .*: `ros2 bag reindex -s sqlite3 .*/run`'),
    'broken metadata': (lambda make, tmp: other_metadata(make(states(3)), '{'),
                        r'^.*/metadata.yaml: is not the metadata of a bag: `ros2 bag reindex .*`'),
    'other metadata': (lambda make, tmp: other_metadata(make(states(3))),
                       r'^.*/metadata.yaml: is not the metadata of a bag'),
    'missing files': (lambda make, tmp: missing_file(make(states(3))),
                      'metadata.yaml names files that are missing: run.mcap; bring them back'),
    'cut mcap': (lambda make, tmp: cut(make(states(20)) / 'run.mcap'),
                 'is cut short .*: `mcap recover .*/run.mcap -o repaired.mcap`$'),
    'cut folder': (lambda make, tmp: cut(make(states(20)) / 'run.mcap').parent,
                   '^.*/run/run.mcap: is cut short .*: `mcap recover .*/run.mcap'),
    'cut db3': (lambda make, tmp: cut(make(states(200), 'sqlite3') / 'run.db3'),
                r'cannot be read \(.*malformed\); if .*: `sqlite3 .*/run.db3 .recover \| sqlite3'),
    'cut bag': (lambda make, tmp: cut(make(states(20), 'ros1')),
                r'cannot be read \(.*\); if it is .* cut short: `rosbag reindex .*/run.bag`$'),
    'unindexed bag': (lambda make, tmp: unindexed_ros1(make(states(20), 'ros1')),
                      r'cannot be read \(.*not indexed.*\).*: `rosbag reindex .*/run.bag`$'),
    'unsorted mcap': (lambda make, tmp: unsorted(make), '.*: `mcap sort .*/run.mcap -o'),
    'unmerged db3': (lambda make, tmp: unmerged(make(states(3), 'sqlite3')),
                     r'^.*/left/run.db3: its last messages are in run.db3-wal .*: `sqlite3 .*'),
    'mark in a path': (lambda make, tmp: make(states(3), 'sqlite3').rename(tmp / 'run#1'),
                       'cannot be read .*: move it to a path without any of [?] # %$'),
    'fewer messages': (lambda make, tmp: too_many_promised(make(states(20))),
                       f'10 messages on {TOPIC} are missing'),
    'not a joint state': (lambda make, tmp: undecodable(make),
                          rf'{TOPIC}: the message received at \d+ ns is not a joint state'),
    'no messages': (lambda make, tmp: make([]), 'holds no messages$'),
    'no joint states': (lambda make, tmp: make([('/b', 1, 'x'), ('/a', 1, 'x')]),
                        'no topic holds joint states; there are /a, /b$'),
    'only grippers': (lambda make, tmp: make(states(3, GRIPPER)),
                      f'{TOPIC} has no joints of an arm, only {", ".join(GRIPPER)}$'),
    'no names': (lambda make, tmp: make(states(3, ())),
                 f'{TOPIC} has no joints of an arm, for its joint states name no joints$'),
    'both arms': (lambda make, tmp: make(states(3, ROBOT)),
                  f"{TOPIC} holds both arms' joints: say --arm right or --arm left$"),
    'both arms in turn': (lambda make, tmp: make(states(3, LEFT) + states(9, RIGHT)),
                          f"{TOPIC} holds both arms' joints"),
    'several topics': (lambda make, tmp: make(states(3, topic='/a') + states(3, topic='/b')),
                       "several topics hold an arm's joints: say --topic /a or --topic /b$"),
    'topics of grippers': (lambda make, tmp: make(states(3, GRIPPER[:1], '/a')
                                                  + states(3, GRIPPER[1:], '/b')),
                           rf'no topic holds joints of an arm; /a has {GRIPPER[0]}; /b has '),
}


def read(path, topic=None, arm=None):
    with open_bag(path, topic, arm) as recording:
        return list(recording)


def line_of(path, *args):
    with pytest.raises(BagError) as caught:
        read(path, *args)
    line = str(caught.value)
    assert '\n' not in line
    assert line.startswith(str(path.parent))
    return line


@pytest.mark.parametrize('make_broken, pattern', BROKEN.values(), ids=BROKEN.keys())
def test_says_what_is_wrong(make_bag, tmp_path, make_broken, pattern):
    path = make_broken(make_bag, tmp_path)
    if not pattern.startswith('^'):
        pattern = f'^{re.escape(str(path))}: {pattern}'
    line = line_of(path)
    assert re.search(pattern, line), line


@pytest.mark.parametrize('topic, arm, end', [
    ('/none', None, f'has no messages on /none; joint states are on {TOPIC}'),
    ('/talk', None, '/talk holds std_msgs/msg/String, not sensor_msgs/msg/JointState; joint '
                    f'states are on {TOPIC}'),
    (None, 'left', f'{TOPIC} has no joints of the left arm, only {", ".join(sorted(RIGHT))}'),
], ids=['topic', 'type', 'arm'])
@pytest.mark.parametrize('kind', KINDS)
def test_says_what_there_is_instead(make_bag, kind, topic, arm, end):
    path = make_bag([('/talk', START, 'hello'), *states(3)], kind)
    assert line_of(path, topic, arm) == f'{path}: {end}'


@pytest.mark.parametrize('kind', KINDS)
def test_what_is_refused_is_closed(make_bag, kind):
    recording = open_bag(make_bag(states(3, ROBOT), kind))
    before = os.listdir('/proc/self/fd')
    with pytest.raises(BagError, match='both arms'):
        recording.__enter__()
    assert len(os.listdir('/proc/self/fd')) == len(before)


def test_long_lists_are_cut(make_bag):
    names = [f'joint_{i:02}' for i in range(30)]
    line = line_of(make_bag(states(3, names)))
    assert line.endswith('only ' + ', '.join(names[:8]) + ' and 22 more')


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('what', ['file', 'folder'])
def test_permission_denied(make_bag, tmp_path, kind, what):
    path = make_bag(states(3), kind)
    file = path if path.is_file() else max(path.iterdir(), key=lambda file: file.stat().st_size)
    closed = file if what == 'file' else file.parent
    folders = [folder for folder in tmp_path.parents if folder.name.startswith('pytest-')]
    modes = {folder: folder.stat().st_mode for folder in (*folders, tmp_path, closed)}
    is_root = os.geteuid() == 0
    try:
        for folder in (*folders, tmp_path):
            folder.chmod(0o755)
        closed.chmod(0)
        if is_root:
            os.seteuid(65534)  # nobody: root may read everything
        assert 'permission denied; make it readable' in line_of(path)
    finally:
        if is_root:
            os.seteuid(0)
        for folder, mode in modes.items():
            folder.chmod(mode)


@pytest.mark.parametrize('fraction', [0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97])
@pytest.mark.parametrize('kind', KINDS)
def test_wherever_it_is_cut(make_bag, kind, fraction):
    path = make_bag(states(3000), kind)
    file = path if path.is_file() else max(path.iterdir(), key=lambda file: file.stat().st_size)
    cut(file, fraction)
    line_of(path)


@pytest.mark.parametrize('kind', KINDS)
def test_garbage_is_one_line_or_still_joint_states(make_bag, rng, kind):
    path = make_bag(states(300), kind)
    file = path if path.is_file() else max(path.iterdir(), key=lambda file: file.stat().st_size)
    data = file.read_bytes()
    failures = 0
    for _ in range(40):
        broken = bytearray(data)
        at, n = rng.integers(len(data)), rng.integers(1, 200)
        broken[at:at + n] = rng.bytes(n)
        file.write_bytes(broken[:len(data)])
        try:
            assert len(read(path)) == 300
        except BagError as error:
            failures += 1
            assert '\n' not in str(error)
    assert failures > 10


def test_mcap_without_summary_is_read(make_bag):
    path = make_bag(states(20)) / 'run.mcap'
    remove_summary(path)
    assert [state.stamp_ns for state in read(path)] == [row[1] for row in states(20)]


@pytest.mark.parametrize('kind, end', [('mcap', 'mcap'), ('ros1', '')])
def test_reads_as_it_goes(make_bag, kind, end):
    """What is broken further on does not keep the beginning from being played."""
    path = file = make_bag(states(8000), kind)
    if end:
        file = path / f'{path.name}.{end}'
    data = bytearray(file.read_bytes())
    middle = len(data) // 2
    data[middle:middle + 4000] = bytes([255]) * 4000
    file.write_bytes(data)
    with open_bag(path, arm='right') as recording:
        played = iter(recording)
        for _ in range(2000):  # more than the arm is looked for in
            next(played)
        with pytest.raises(BagError, match=f'^{path}: '):
            list(played)

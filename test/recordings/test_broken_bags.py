"""Broken bags are refused in one line that names the cause, and nothing is written."""

import os
import re
import shutil
import sqlite3

import pytest
from recordings.joint_states import GRIPPER, KINDS, ROBOT, states, TOPIC

pytest.importorskip('rosbags', reason='reading bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.recordings.bags import BagRecording, open_recordings  # noqa: E402, I100
from baxter_dynamics_ros.recordings.recording import BagError  # noqa: E402


def largest(path):
    """Return the file that holds the messages of a bag."""
    return path if path.is_file() else max(path.iterdir(), key=lambda file: file.stat().st_size)


def cut(path, size=None):
    os.truncate(path, path.stat().st_size * 6 // 10 if size is None else size)
    return path


def unindexed_ros1(path):
    data = bytearray(path.read_bytes())
    at = data.index(b'index_pos=') + len('index_pos=')
    data[at:at + 8] = bytes(8)
    path.write_bytes(data)
    return path


def without(path, name):
    (path / name).unlink()
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


def undecodable(path, number):
    with sqlite3.connect(path / 'run.db3') as database:
        database.execute(f"UPDATE messages SET data = x'0001000000' WHERE id = {number}")
    database.close()
    return path


def listing(path, name):
    metadata = path / 'metadata.yaml'
    return text(metadata, metadata.read_text().replace('run.mcap', name)).parent


def text(path, content='hello world\n' * 100):
    path.write_text(content)
    return path


def inner(path, folder):
    folder.mkdir()
    path.rename(folder / path.name)
    return folder


# Name -> how to make the bag from (make_bag, tmp_path), and a pattern for the message after its
# path.
BROKEN = {
    'missing': (lambda make, tmp: tmp / 'none', 'no such file or folder'),
    'empty mcap': (lambda make, tmp: text(tmp / 'x.mcap', ''), 'is empty$'),
    'text': (lambda make, tmp: text(tmp / 'x.txt'), 'is not a bag: expected a rosbag2 folder'),
    'text db3': (lambda make, tmp: text(tmp / 'x.db3'), 'is not an SQLite file'),
    'old bag': (lambda make, tmp: text(tmp / 'x.bag', '#ROSBAG V1.2\n'),
                'is not a ROS 1 bag of version 2.0'),
    'folder of bags': (lambda make, tmp: inner(make(states(3)), tmp / 'y'),
                       r'is not a bag: .*; choose one of the bags in it: run$'),
    'metadata itself': (lambda make, tmp: make(states(3)) / 'metadata.yaml',
                        'is part of a bag: name the folder .*/run$'),
    'no metadata': (lambda make, tmp: without(make(states(3)), 'metadata.yaml'),
                    'has no metadata.yaml .*: `ros2 bag reindex -s mcap .*/run` writes it$'),
    'no metadata, SQLite': (lambda make, tmp: without(make(states(3), 'sqlite3'), 'metadata.yaml'),
                            'has no metadata.yaml .*: `ros2 bag reindex -s sqlite3 .*/run`'),
    'no metadata, zstd': (lambda make, tmp: inner(text(tmp / 'x.mcap.zstd'), tmp / 'y'),
                          'has no metadata.yaml; choose one of the bags in it: x.mcap.zstd$'),
    'folder listed': (lambda make, tmp: listing(make(states(3)), '..'),
                      r'^.*/run/\.\.: is not a file of a bag$'),
    'metadata listed': (lambda make, tmp: listing(make(states(3)), 'metadata.yaml'),
                        '^.*/metadata.yaml: is not a file of a bag$'),
    'other metadata': (lambda make, tmp: text(make(states(3)) / 'metadata.yaml', '{}').parent,
                       r'^.*/metadata.yaml: is not the metadata of a bag'),
    'missing files': (lambda make, tmp: without(make(states(3)), 'run.mcap'),
                      'metadata.yaml lists files that are missing: run.mcap; restore them'),
    'cut mcap': (lambda make, tmp: cut(make(states(20)) / 'run.mcap'),
                 'is truncated .*: `mcap recover .*/run.mcap -o repaired.mcap`$'),
    'cut folder': (lambda make, tmp: cut(make(states(20)) / 'run.mcap', 8).parent,
                   '^.*/run/run.mcap: is truncated .*: `mcap recover .*/run.mcap'),
    'cut db3': (lambda make, tmp: cut(make(states(200), 'sqlite3') / 'run.db3'),
                r'cannot be read \(.*malformed\); if .*: `sqlite3 .*/run.db3 .recover \| sqlite3'),
    'cut bag': (lambda make, tmp: cut(make(states(20), 'ros1')),
                r'cannot be read \(.*\); if it is damaged: `rosbag reindex .*/run.bag`$'),
    'unindexed bag': (lambda make, tmp: unindexed_ros1(make(states(20), 'ros1')),
                      r'cannot be read \(.*not indexed.*\); .*: `rosbag reindex .*/run.bag`$'),
    'unmerged db3': (lambda make, tmp: unmerged(make(states(3), 'sqlite3')),
                     r'^.*/left/run.db3: its last messages are in run.db3-wal .*: `sqlite3 .*'),
    'not a joint state': (lambda make, tmp: undecodable(make(states(20), 'sqlite3'), 12),
                          rf'{TOPIC}: the message received at \d+ ns is not a joint state'),
    'no messages': (lambda make, tmp: make([]), 'no joint states in .*; it has no messages$'),
    'no joint states': (lambda make, tmp: make([('/b', 1, 'x'), ('/a', 1, 'x')]),
                        r'no joint states in .*; it has /a \(std_msgs/msg/String, cdr\), /b'),
    'only grippers': (lambda make, tmp: make(states(3, GRIPPER)),
                      f'{TOPIC} has no joints of an arm, only {", ".join(GRIPPER)}$'),
    'many joints': (lambda make, tmp: make(states(3, [f'{i:02}/left_e0' for i in range(30)])),
                    f'{TOPIC} has no .*, only 00/.* 07/left_e0 and 22 more; .* joint_prefix$'),
    'no names': (lambda make, tmp: make(states(3, ())),
                 f'{TOPIC} has no joints of an arm, its joint states name no joints$'),
    'both arms': (lambda make, tmp: make(states(3, ROBOT)),
                  f"{TOPIC} has both arms' joints: choose --arm right or --arm left$"),
    'several topics': (lambda make, tmp: make(states(3, topic='/a') + states(3, topic='/b')),
                       "several topics have an arm's joints: choose --topic /a or --topic /b$"),
    'topics of grippers': (lambda make, tmp: make(states(3, GRIPPER[:1], '/a')
                                                  + states(3, GRIPPER[1:], '/b')),
                           rf'/a has no joints of an arm, only {GRIPPER[0]}$'),
}


def read(path, topic=None):
    (recording,) = open_recordings([path], topic)
    with recording:
        return list(recording)


def line_of(path, topic=None):
    with pytest.raises(BagError) as caught:
        read(path, topic)
    line = str(caught.value)
    assert '\n' not in line and line.startswith(str(path.parent))
    return line


@pytest.mark.parametrize('name', BROKEN)
def test_message_names_the_cause(make_bag, tmp_path, name):
    make_broken, pattern = BROKEN[name]
    path = make_broken(make_bag, tmp_path)
    if not pattern.startswith('^'):
        pattern = f'^{re.escape(str(path))}: {pattern}'
    line = line_of(path)
    assert re.search(pattern, line), line


@pytest.mark.parametrize('topic', ['/none', '/talk'])
def test_message_lists_the_topics(make_bag, topic):
    path = make_bag([('/talk', 1, 'hello'), *states(3)], 'ros1')
    assert line_of(path, topic) == (
        f'{path}: no joint states in CDR or ROS 1 encoding on {topic}; it has {TOPIC} '
        '(sensor_msgs/msg/JointState, ros1), /talk (std_msgs/msg/String, ros1)')


@pytest.mark.parametrize('kind', KINDS)
def test_refused_bags_are_closed(make_bag, kind):
    path = make_bag(states(3, ROBOT), kind)
    before = os.listdir('/proc/self/fd')
    assert 'both arms' in line_of(path)
    assert len(os.listdir('/proc/self/fd')) == len(before)


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('what', ['file', 'folder'])
def test_permission_denied(make_bag, closed, kind, what):
    path = make_bag(states(3), kind)
    with closed(largest(path) if what == 'file' else largest(path).parent):
        assert 'permission denied; make it readable' in line_of(path)


def test_a_bag_without_space_for_temporary_files_is_not_missing(make_bag, monkeypatch):
    monkeypatch.setattr('tempfile.tempdir', '/none')
    line = line_of(make_bag(states(3)))
    assert 'run.mcap: cannot be read (No such file or directory)' in line


@pytest.mark.parametrize('kind', KINDS)
def test_damaged_files_are_refused_or_the_damage_is_harmless(make_bag, rng, kind):
    path = make_bag(states(300), kind)
    file, failures = largest(path), 0
    data = file.read_bytes()
    for _ in range(12):
        broken = bytearray(data)
        at, n = rng.integers(len(data)), rng.integers(1, 200)
        broken[at:at + n] = rng.bytes(n)
        file.write_bytes(broken[:len(data)])
        try:
            assert len(read(path)) == 300
        except BagError as error:
            failures += 1
            assert '\n' not in str(error)
    assert failures > 3
    for fraction in (0.97, 0.3, 0.01):
        file.write_bytes(data[:int(fraction * len(data))])
        line_of(path)


def test_messages_before_the_damage_are_read(make_bag, refused, monkeypatch):
    monkeypatch.setattr(f'{BagRecording.__module__}._PEEK', 50)  # where the arm is looked for
    path = undecodable(make_bag(states(200), 'sqlite3'), 100)
    with BagRecording(path, arm='right') as recording:
        played = iter(recording)
        for _ in range(99):
            next(played)
        with pytest.raises(BagError, match=f'^{path}: {TOPIC}: the message received at'):
            next(played)
    # Nothing is left of a report and a bag half way.
    assert refused('evaluate', path, '--save-bag', 'new').startswith(f'{path}: {TOPIC}')


@pytest.mark.parametrize('name', ['evaluate', 'calibrate'])
def test_a_broken_bag_behind_a_good_one_is_refused(refused, make_bag, name):
    good, broken = make_bag(states(30)), make_bag(states(30), name='broken')
    assert refused(name, good, without(broken, 'metadata.yaml')).startswith(
        f'{broken}: has no metadata.yaml')

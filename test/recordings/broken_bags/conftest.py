"""Broken bags, and the message expected for each."""

import os
import re
import shutil
import sqlite3
import struct
from typing import NamedTuple

from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

TOPIC = '/robot/joint_states'
START = 1_700_000_000_123_456_789  # [ns]
RIGHT, LEFT = joint_names('right'), joint_names('left')
ROBOT = ('head_nod', 'head_pan', *LEFT, *RIGHT, 'torso_t0')
GRIPPER = ('r_gripper_l_finger_joint', 'r_gripper_r_finger_joint')


def states(n, names=RIGHT, topic=TOPIC):
    """Return n joint states, 10 ms apart."""
    values = np.arange(3.0 * len(names)).reshape(3, -1)
    return [(topic, START + i * 10_000_000, (START + i * 10_000_000, names, *values))
            for i in range(n)]


def remove_summary(file):
    """Make an MCAP file look like that of a recorder that writes no index."""
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


# Name -> how to make the bag from (make_bag, tmp_path), and a pattern for the message after its
# path.
BROKEN = {
    'missing': (lambda make, tmp: tmp / 'none', 'no such file or folder'),
    'below a file': (lambda make, tmp: text(tmp / 'x.bag') / 'y', 'no such file'),
    'empty mcap': (lambda make, tmp: text(tmp / 'x.mcap', ''), 'is empty$'),
    'empty db3': (lambda make, tmp: text(tmp / 'x.db3', ''), 'is empty$'),
    'empty bag': (lambda make, tmp: text(tmp / 'x.bag', ''), 'is empty$'),
    'text': (lambda make, tmp: text(tmp / 'x.txt'), 'is not a bag: expected a rosbag2 folder'),
    'text mcap': (lambda make, tmp: text(tmp / 'x.mcap'), 'is not an MCAP file'),
    'text db3': (lambda make, tmp: text(tmp / 'x.db3'), 'is not an SQLite file'),
    'text bag': (lambda make, tmp: text(tmp / 'x.bag'), 'is not a ROS 1 bag of version 2.0'),
    'old bag': (lambda make, tmp: text(tmp / 'x.bag', '#ROSBAG V1.2\n'), 'is not a ROS 1 bag of'),
    'empty folder': (lambda make, tmp: inner(text(tmp / 'x'), tmp / 'y'),
                     'is not a bag: it has no metadata.yaml$'),
    'folder of bags': (lambda make, tmp: inner(make(states(3)), tmp / 'y'),
                       r'is not a bag: .*; choose one of the bags in it: run$'),
    'metadata itself': (lambda make, tmp: make(states(3)) / 'metadata.yaml',
                        'is part of a bag: name the folder .*/run$'),
    'no metadata': (lambda make, tmp: missing_metadata(make(states(3))),
                    'has no metadata.yaml .*: `ros2 bag reindex -s mcap .*/run` writes it$'),
    'no metadata db3': (lambda make, tmp: missing_metadata(make(states(3), 'sqlite3')),
                        'has no metadata.yaml .*: `ros2 bag reindex -s sqlite3 .*/run`'),
    'broken metadata': (lambda make, tmp: other_metadata(make(states(3)), '{'),
                        r'^.*/metadata.yaml: is not the metadata of a bag: `ros2 bag reindex .*`'),
    'other metadata': (lambda make, tmp: other_metadata(make(states(3))),
                       r'^.*/metadata.yaml: is not the metadata of a bag'),
    'missing files': (lambda make, tmp: missing_file(make(states(3))),
                      'metadata.yaml lists files that are missing: run.mcap; restore them'),
    'cut mcap': (lambda make, tmp: cut(make(states(20)) / 'run.mcap'),
                 'is truncated .*: `mcap recover .*/run.mcap -o repaired.mcap`$'),
    'cut folder': (lambda make, tmp: cut(make(states(20)) / 'run.mcap').parent,
                   '^.*/run/run.mcap: is truncated .*: `mcap recover .*/run.mcap'),
    'cut db3': (lambda make, tmp: cut(make(states(200), 'sqlite3') / 'run.db3'),
                r'cannot be read \(.*malformed\); if .*: `sqlite3 .*/run.db3 .recover \| sqlite3'),
    'cut bag': (lambda make, tmp: cut(make(states(20), 'ros1')),
                r'cannot be read \(.*\); if it is damaged: `rosbag reindex .*/run.bag`$'),
    'unindexed bag': (lambda make, tmp: unindexed_ros1(make(states(20), 'ros1')),
                      r'cannot be read \(.*not indexed.*\); .*: `rosbag reindex .*/run.bag`$'),
    'unmerged db3': (lambda make, tmp: unmerged(make(states(3), 'sqlite3')),
                     r'^.*/left/run.db3: its last messages are in run.db3-wal .*: `sqlite3 .*'),
    'not a joint state': (lambda make, tmp: undecodable(make),
                          rf'{TOPIC}: the message received at \d+ ns is not a joint state'),
    'no messages': (lambda make, tmp: make([]), 'no joint states in .*; it has no messages$'),
    'no joint states': (lambda make, tmp: make([('/b', 1, 'x'), ('/a', 1, 'x')]),
                        r'no joint states in .*; it has /a \(std_msgs/msg/String, cdr\), /b'),
    'only grippers': (lambda make, tmp: make(states(3, GRIPPER)),
                      f'{TOPIC} has no joints of an arm, only {", ".join(GRIPPER)}$'),
    'no names': (lambda make, tmp: make(states(3, ())),
                 f'{TOPIC} has no joints of an arm, its joint states name no joints$'),
    'both arms': (lambda make, tmp: make(states(3, ROBOT)),
                  f"{TOPIC} has both arms' joints: choose --arm right or --arm left$"),
    'both arms in turn': (lambda make, tmp: make(states(3, LEFT) + states(9, RIGHT)),
                          f"{TOPIC} has both arms' joints"),
    'several topics': (lambda make, tmp: make(states(3, topic='/a') + states(3, topic='/b')),
                       "several topics have an arm's joints: choose --topic /a or --topic /b$"),
    'topics of grippers': (lambda make, tmp: make(states(3, GRIPPER[:1], '/a')
                                                  + states(3, GRIPPER[1:], '/b')),
                           rf'/a has no joints of an arm, only {GRIPPER[0]}$'),
}


class BrokenBag(NamedTuple):
    """A bag that cannot be used."""

    path: object  # as it is given
    pattern: str  # of the message


@pytest.fixture(params=BROKEN.values(), ids=BROKEN.keys())
def broken_bag(request, make_bag, tmp_path):
    """Return each broken bag in turn, in tmp_path, and the pattern of the line about it."""
    make_broken, pattern = request.param
    path = make_broken(make_bag, tmp_path)
    if not pattern.startswith('^'):
        pattern = f'^{re.escape(str(path))}: {pattern}'
    return BrokenBag(path, pattern)


@pytest.fixture(name='states')
def fixture_states():
    """Return the function that makes joint states for make_bag."""
    return states


@pytest.fixture
def bag_without_summary(make_bag):
    """Return an MCAP file without an index, and the messages in it."""
    path = make_bag(states(20)) / 'run.mcap'
    remove_summary(path)
    return path, states(20)

"""Broken bags are refused in one line that names the cause."""

import os
import re

from baxter_dynamics_ros.model.joints import joint_names
import pytest

pytest.importorskip('rosbags', reason='reading bags needs rosbags: pip install rosbags')
from baxter_dynamics_ros.recordings.reader import BagRecording, open_recordings  # noqa: E402, I100
from baxter_dynamics_ros.recordings.recording import BagError  # noqa: E402

TOPIC = '/robot/joint_states'
RIGHT, LEFT = joint_names('right'), joint_names('left')
KINDS = ['mcap', 'sqlite3', 'ros1']


def read(path, topic=None, arm=None):
    (recording,) = open_recordings([path], topic, arm)
    with recording:
        return list(recording)


def line_of(path, *args):
    with pytest.raises(BagError) as caught:
        read(path, *args)
    line = str(caught.value)
    assert '\n' not in line
    assert line.startswith(str(path.parent))
    return line


def test_message_names_the_cause(broken_bag):
    line = line_of(broken_bag.path)
    assert re.search(broken_bag.pattern, line), line


@pytest.mark.parametrize('topic', ['/none', '/talk'])
@pytest.mark.parametrize('kind', KINDS)
def test_message_lists_the_topics(make_bag, states, kind, topic):
    path = make_bag([('/talk', 1, 'hello'), *states(3)], kind)
    encoding = 'ros1' if kind == 'ros1' else 'cdr'
    assert line_of(path, topic) == (
        f'{path}: no joint states in CDR or ROS 1 encoding on {topic}; it has {TOPIC} '
        f'(sensor_msgs/msg/JointState, {encoding}), /talk (std_msgs/msg/String, {encoding})')


@pytest.mark.parametrize('kind', KINDS)
def test_refused_bags_are_closed(make_bag, states, kind):
    recording = BagRecording(make_bag(states(3, LEFT + RIGHT), kind))
    before = os.listdir('/proc/self/fd')
    with pytest.raises(BagError, match='both arms'):
        recording.__enter__()
    assert len(os.listdir('/proc/self/fd')) == len(before)


def test_long_lists_are_cut(make_bag, states):
    names = [f'joint_{i:02}' for i in range(30)]
    line = line_of(make_bag(states(3, names)))
    assert line.endswith('only ' + ', '.join(names[:8]) + ' and 22 more')


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('what', ['file', 'folder'])
def test_permission_denied(make_bag, states, closed, kind, what):
    path = make_bag(states(3), kind)
    file = path if path.is_file() else max(path.iterdir(), key=lambda file: file.stat().st_size)
    with closed(file if what == 'file' else file.parent):
        assert 'permission denied; make it readable' in line_of(path)


@pytest.mark.parametrize('fraction', [0.01, 0.3, 0.7, 0.97])
@pytest.mark.parametrize('kind', KINDS)
def test_truncated_files_are_refused(make_bag, states, kind, fraction):
    path = make_bag(states(3000), kind)
    file = path if path.is_file() else max(path.iterdir(), key=lambda file: file.stat().st_size)
    os.truncate(file, int(file.stat().st_size * fraction))
    line_of(path)


@pytest.mark.parametrize('kind', KINDS)
def test_damaged_bytes_are_refused_or_harmless(make_bag, states, rng, kind):
    path = make_bag(states(300), kind)
    file = path if path.is_file() else max(path.iterdir(), key=lambda file: file.stat().st_size)
    data = file.read_bytes()
    failures = 0
    for _ in range(20):
        broken = bytearray(data)
        at, n = rng.integers(len(data)), rng.integers(1, 200)
        broken[at:at + n] = rng.bytes(n)
        file.write_bytes(broken[:len(data)])
        try:
            assert len(read(path)) == 300
        except BagError as error:
            failures += 1
            assert '\n' not in str(error)
    assert failures > 5


def test_mcap_without_summary_is_read(bag_without_summary):
    path, messages = bag_without_summary
    assert [state.stamp_ns for state in read(path)] == [message[1] for message in messages]


@pytest.mark.parametrize('kind, end', [('mcap', 'mcap'), ('ros1', '')])
def test_messages_before_the_damage_are_read(make_bag, states, kind, end):
    path = file = make_bag(states(8000), kind)
    if end:
        file = path / f'{path.name}.{end}'
    data = bytearray(file.read_bytes())
    middle = len(data) // 2
    data[middle:middle + 4000] = bytes([255]) * 4000
    file.write_bytes(data)
    with BagRecording(path, arm='right') as recording:
        played = iter(recording)
        for _ in range(2000):  # more than the arm is looked for in
            next(played)
        with pytest.raises(BagError, match=f'^{path}: '):
            list(played)

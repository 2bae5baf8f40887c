"""Deserialisation of ROS 1 messages and headers, clock offset, and counts of messages."""

from contextlib import suppress
import struct
import tracemalloc

from baxter_dynamics_ros.ros1.source import ClockOffset, Source
from baxter_dynamics_ros.ros1.wire import (decode_header, encode_header, JointState, Malformed,
                                           MD5SUM, parse, TYPE)
from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

BEGIN = 1_500_000_000_000_000_000  # [ns]
GOOD = bytes.fromhex('07000000 01000000 02000000 00000000 01000000 01000000 61'
                     '01000000 000000000000f03f 00000000 00000000')
FLOATS = st.lists(st.floats(allow_nan=False), max_size=5)


@given(st.integers(0, 2 ** 32 - 1), st.integers(0, 2 ** 31 - 1), st.integers(0, 999_999_999),
       st.lists(st.text(max_size=5), max_size=5), st.tuples(FLOATS, FLOATS, FLOATS))
@settings(max_examples=30, deadline=None)
def test_joint_states_are_read_as_they_were_written(seq, seconds, nanoseconds, names, arrays):
    typesys = pytest.importorskip('rosbags.typesys', reason='needs rosbags: pip install rosbags')
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    kind = 'sensor_msgs/msg/JointState'
    types = store.types
    message = types[kind](
        types['std_msgs/msg/Header'](
            seq, types['builtin_interfaces/msg/Time'](seconds, nanoseconds), 'base'),
        names, *(np.array(array, dtype=float) for array in arrays))
    state = parse(bytes(store.serialize_ros1(message, kind)))
    assert state[:4] == (seq, seconds * 10 ** 9 + nanoseconds, 'base', names)
    assert [list(array) for array in state[4:]] == list(arrays)
    assert store.generate_msgdef(kind, ros_version=1)[1] == MD5SUM and TYPE == kind.replace(
        '/msg', '')


@given(st.binary(max_size=200) | st.builds(
    lambda cut, at, junk: GOOD[:at] + junk + GOOD[at + cut:], st.integers(0, 8),
    st.integers(0, len(GOOD)), st.binary(max_size=8)))
@settings(max_examples=200, deadline=None)
def test_arbitrary_data_are_a_joint_state_or_malformed(data):
    for read in (parse, decode_header):
        with suppress(Malformed):
            assert isinstance(read(data), (JointState, dict))


def test_a_field_longer_than_the_message_takes_no_memory():
    assert parse(GOOD).name == ['a'] and list(parse(GOOD).position) == [1.0]
    tracemalloc.start()
    for at in (12, 16, 20, 25):
        with pytest.raises(Malformed):
            parse(GOOD[:at] + struct.pack('<I', 2 ** 32 - 1) + GOOD[at + 4:])
    assert tracemalloc.get_traced_memory()[1] < 1e5
    tracemalloc.stop()


def test_headers_are_read_as_they_were_written():
    fields = {'callerid': '/robot', 'error': 'a = b', 'märchen': ''}
    data = encode_header(fields)
    assert decode_header(data[4:]) == fields and data[:4] == struct.pack('<I', len(data) - 4)


def arrivals(n, offset, seed=0):
    """Return stamps and times of arrival [ns] at 100 Hz, late by 1 ms and more."""
    random = np.random.default_rng(seed)
    stamps = BEGIN + 10_000_000 * np.arange(n)
    late = 0.001 + random.exponential(0.004, n)
    return [int(x) for x in stamps], [int(x) for x in stamps + 1e9 * (offset + late)]


def test_clock_offset_follows_the_fastest_arrivals_slowly():
    clock = ClockOffset()
    drift = 50e-6  # the machines' clocks
    found = [clock.update(stamp, arrival + int(drift * 10_000_000 * k))
             for k, (stamp, arrival) in enumerate(zip(*arrivals(6000, 2.6)))]
    assert np.abs(np.diff(found)).max() <= 20_000 + 1  # 0.2 % of 10 ms
    wanted = 2.601 + drift * 0.01 * np.arange(6000)
    assert np.abs(np.array(found[2000:]) * 1e-9 - wanted[2000:]).max() < 1e-3
    assert clock.steps == 0


@pytest.mark.parametrize('change', [-3.0, 3.0])
def test_clock_offset_restarts_when_a_clock_is_set(change):
    clock = ClockOffset()
    for shift in (0.0, change):
        found = [clock.update(*pair) * 1e-9 for pair in zip(*arrivals(400, 1.0 + shift))]
        assert found == pytest.approx(400 * [1.001 + shift], abs=0.02)  # from the first message on
    assert clock.steps == 1


def test_delayed_messages_do_not_move_the_clock_offset():
    clock = ClockOffset()
    stamps, times = arrivals(1500, 1.0)
    held = [max(arrival, times[1000]) if 500 <= k < 1000 else arrival
            for k, arrival in enumerate(times)]
    found = [clock.update(*pair) for pair in zip(stamps, held)]
    assert clock.steps == 0 and np.abs(np.diff(found)).max() <= 20_001


def test_lost_and_repeated_messages_are_counted_by_their_numbers():
    source = Source('/robot')

    def take(uri, *numbers):
        return [source.take(uri, JointState(
            seq % 2 ** 32, BEGIN + seq, '', [], [float('nan')], [], []), BEGIN) for seq in numbers]
    assert take('http://a:1/', 1, 2, 5, 5, 6) == [True, True, True, False, True]
    assert (source.received, source.lost, source.repeated) == (4, 2, 1)
    take('http://a:2/', 50, 51)  # another process: its numbers began anew
    take('http://a:2/', 1, 2)  # the same restarted
    take('http://a:3/', 2 ** 32 - 1, 2 ** 32, 2 ** 32 + 2)  # the number wraps around
    assert (source.received, source.lost, source.repeated) == (11, 3, 1)
    for _ in range(2):  # without a number and a stamp, at rest
        assert source.take('http://b:1/', JointState(0, 0, '', [], [1.0], [], []), BEGIN)

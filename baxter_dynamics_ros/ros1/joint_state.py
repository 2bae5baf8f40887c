"""Deserialisation of ROS 1 ``sensor_msgs/JointState``."""

from array import array
import struct
from typing import NamedTuple

from .errors import Malformed

TYPE = 'sensor_msgs/JointState'
MD5SUM = '3066dcd76a6cfaef579bd0f34173e9fd'


class JointState(NamedTuple):
    """A ROS 1 joint state."""

    seq: int  # sequence number of the publisher
    stamp_ns: int  # [ns]
    frame_id: str
    name: list[str]
    position: 'array[float]'
    velocity: 'array[float]'
    effort: 'array[float]'


def parse(data: bytes) -> JointState:
    """Return the joint state in a message; raise Malformed if it is not exactly one."""
    try:
        seq, seconds, nanoseconds = struct.unpack_from('<3I', data)
        frame_id, at = _text(data, 12)
        count, at = _count(data, at, 4)
        names = []
        for _ in range(count):
            name, at = _text(data, at)
            names.append(name)
        position, at = _floats(data, at)
        velocity, at = _floats(data, at)
        effort, at = _floats(data, at)
    except (struct.error, UnicodeDecodeError) as error:
        raise Malformed(f'not a joint state: {error}') from None
    if at != len(data):
        raise Malformed(f'not a joint state: {len(data) - at} bytes too many')
    return JointState(seq, seconds * 1_000_000_000 + nanoseconds, frame_id, names, position,
                      velocity, effort)


def _count(data: bytes, at: int, size: int) -> tuple[int, int]:
    """Return the number of items of at least ``size`` bytes, and the offset of the first."""
    count, = struct.unpack_from('<I', data, at)
    at += 4
    if count * size > len(data) - at:
        raise Malformed(f'not a joint state: {count} items in {len(data) - at} bytes')
    return count, at


def _text(data: bytes, at: int) -> tuple[str, int]:
    length, at = _count(data, at, 1)
    return data[at:at + length].decode(), at + length


def _floats(data: bytes, at: int) -> 'tuple[array[float], int]':
    count, at = _count(data, at, 8)
    return array('d', struct.unpack_from(f'<{count}d', data, at)), at + 8 * count

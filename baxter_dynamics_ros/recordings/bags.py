"""Recordings in bags of ROS 1 and ROS 2: an arm's joint states, in the order of recording."""

from collections.abc import Iterator, Sequence
from itertools import islice
import os
from pathlib import Path
from typing import Any, NamedTuple

from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader

from .choice import choose_arm, choose_topic
from .definitions import JOINT_STATE, ros1, ros2
from .diagnosis import bag_error, BagError, refuse_unfinished
from .writer import BagWriter
from ..model.arrays import Array

_PEEK = 1000  # messages that tell which joints a topic is about


class JointState(NamedTuple):
    """A joint state as recorded, whatever is in it."""

    stamp_ns: int  # the header's [ns]
    names: Sequence[str]  # its joints
    position: Array  # [rad]; as long as names, unless the message is malformed
    velocity: Array  # [rad/s]; as long, or empty
    effort: Array  # [N m]; as long, or empty
    received_ns: int  # when it was recorded [ns]


class BagRecording:
    """
    The joint states of one arm in a bag; a context manager, for the bag is open within.

    Iterate over it for each :class:`JointState` on its topic, as often as you like. Memory does
    not grow with the bag, but for the index that a ROS 1 bag needs.

    Parameters
    ----------
    path : Path
        A folder of rosbag2 (MCAP or SQLite), one of its files, or a ROS 1 bag.
    topic : str, optional
        Where its joint states are; by default the robot's usual topic, or else the only one with
        an arm's joints.
    arm : str, optional
        'right' or 'left'; by default the only arm in the bag.

    Attributes
    ----------
    path : Path
        The bag.
    name : str
        Its folder's or file's, without ending.
    topic, arm : str
        As given or, once open, as found.
    count : int
        How many joint states the topic has; once open.

    Raises
    ------
    BagError
        If it cannot be read, or does not have that; while iterating, too.

    """

    def __init__(self, path: Path, topic: str | None = None, arm: str | None = None) -> None:
        self.path = Path(path)
        self.name = _name(self.path)
        self.topic: str = topic  # type: ignore[assignment]  # None until it is open
        self.arm: str = arm  # type: ignore[assignment]
        self.count = 0
        self._wanted = (topic, arm)

    def __enter__(self) -> 'BagRecording':
        """Open it and find topic and arm."""
        try:
            refuse_unfinished(self.path)
            is_ros1 = self.path.suffix in ('.bag', '.active') and not self.path.is_dir()
            self._decode = ros1().deserialize_ros1 if is_ros1 else ros2().deserialize_cdr
            self._reader = (Ros1Reader if is_ros1 else Ros2Reader)(self.path)
            self._reader.open()
        except BagError:
            raise
        except Exception as error:  # of a parser: whatever a broken file leads it to
            raise bag_error(self.path, error) from None
        try:
            self._choose(*self._wanted)
        except BaseException:
            self._reader.close()
            raise
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Close it."""
        self._reader.close()

    def __iter__(self) -> Iterator[JointState]:
        """Yield each :class:`JointState` of the topic."""
        return self._play(self.topic)

    def copied_to(self, writer: BagWriter) -> Iterator[JointState]:
        """Yield the same, and on the way copy every message of the bag, of all topics."""
        return self._play(self.topic, writer)

    def _choose(self, topic: 'str | None', arm: 'str | None') -> None:
        topics: dict[str, set[str]] = {}
        for connection in self._reader.connections:
            if connection.msgcount:
                topics.setdefault(connection.topic, set()).add(connection.msgtype)
        self.topic = choose_topic(self.path, topics, topic, arm, self._peek)
        self.arm = choose_arm(f'{self.path}: {self.topic}', self._peek(self.topic), arm)
        self.count = sum(connection.msgcount for connection in self._connections(self.topic))

    def _connections(self, topic: str) -> list[Connection]:
        return [connection for connection in self._reader.connections
                if connection.topic == topic and connection.msgtype == JOINT_STATE]

    def _peek(self, topic: str) -> set[str]:
        """Return the joints that the first messages of a topic name."""
        names: set[str] = set()
        for state in islice(self._play(topic), _PEEK):
            names.update(state.names)
        return names

    def _play(self, topic: str, writer: BagWriter | None = None) -> Iterator[JointState]:
        played = self._connections(topic)
        ids = {connection.id for connection in played}
        missing = sum(connection.msgcount for connection in played)
        connections = played if writer is None else self._reader.connections
        for connection, received_ns, raw in self._messages(connections):
            if writer is not None:
                writer.copy(connection, received_ns, raw)
            if connection.id in ids:
                missing -= 1
                yield self._state(topic, received_ns, raw)
        if missing > 0:  # the library steps over what it does not know
            raise BagError(f'{self.path}: {missing} messages on {topic} are missing: it is '
                           'damaged, or its list of contents is of another file')

    def _messages(self, connections: list[Connection]) -> Iterator[tuple[Connection, int, bytes]]:
        try:
            yield from self._reader.messages(connections)
        except Exception as error:  # of a parser: whatever a broken file leads it to
            raise bag_error(self.path, error) from None

    def _state(self, topic: str, received_ns: int, raw: bytes) -> JointState:
        try:
            message: Any = self._decode(raw, JOINT_STATE)
        except Exception as error:  # of a parser: whatever a broken message leads it to
            raise BagError(f'{self.path}: {topic}: the message received at {received_ns} ns is '
                           f'not a joint state ({error})') from None
        stamp = message.header.stamp
        return JointState(stamp.sec * 10**9 + stamp.nanosec, message.name, message.position,
                          message.velocity, message.effort, received_ns)


def open_bag(path: Path, topic: str | None = None, arm: str | None = None) -> BagRecording:
    """Return a bag's recording, to be opened by ``with``; see :class:`BagRecording`."""
    return BagRecording(path, topic, arm)


def _name(path: Path) -> str:
    path = path.resolve()
    return path.name if os.path.isdir(path) else path.stem

"""Joint states of one arm in a bag of ROS 1 or ROS 2, in the order of recording."""

from collections.abc import Iterator
from functools import lru_cache
import os
from pathlib import Path
from typing import Any

from rosbags.serde import SerdeError
from rosbags.typesys import get_typestore, Stores
from rosbags.typesys.store import Typestore

from .bag_errors import bag_error
from .bag_files import BagFiles, Channel
from .recording import BagError, choose_arm, JointState, listed, sides_of, USUAL_TOPIC

JOINT_STATE = 'sensor_msgs/msg/JointState'
_READABLE = ('cdr', 'ros1')  # encodings of messages
_PEEK = 1000  # messages read to find the arms on a topic; more until there is one
_PADDING = (0, 4, 8)  # bytes that some writers append to a message


class BagRecording:
    """
    Joint states of one arm in a bag; a context manager that keeps the bag open.

    Iterating yields each :class:`~.recording.JointState` on the topic, any number of times.
    Memory does not grow with the bag, except for an MCAP file without an index and the index of a
    ROS 1 bag.

    Parameters
    ----------
    path : Path
        A rosbag2 folder (MCAP or SQLite), one of its files, or a ROS 1 bag.
    topic : str, optional
        Topic of the joint states; by default the robot's usual topic, or the only one with an
        arm's joints.
    arm : str, optional
        'right' or 'left'; by default the only arm in the bag.

    Attributes
    ----------
    name : str
        Name of the folder or file, without ending.
    topic, arm : str
        As given or, once open, as found.
    count : int
        Number of joint states on the topic, once open.

    Raises
    ------
    BagError
        If the bag cannot be read or has no such joint states; also while iterating.

    """

    def __init__(self, path: Path, topic: str | None = None, arm: str | None = None) -> None:
        self.path = Path(path)
        name = self.path.resolve().name
        self.name = name if os.path.isdir(self.path) else (
            name.removesuffix('.zstd').rpartition('.')[0])
        self.topic: str = topic  # type: ignore[assignment]  # None until it is open
        self.arm: str = arm  # type: ignore[assignment]
        self.count = 0
        self._names: dict[str, set[str]] = {}  # topic -> joints

    def __enter__(self) -> 'BagRecording':
        """Open the bag and find topic and arm."""
        try:
            self._files = BagFiles(self.path)
        except Exception as error:  # a damaged file makes the libraries raise anything
            raise bag_error(self.path, error) from None
        try:
            self.topic = self._choose_topic(self.topic)
            self.arm = choose_arm(f'{self.path}: {self.topic}', self._peek(self.topic), self.arm)
        except BaseException:
            self._files.close()
            raise
        self.count = sum(channel.count for channel in self._channels(self.topic))
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Close the bag."""
        self._files.close()

    def __iter__(self) -> Iterator[JointState]:
        """Yield each joint state of the topic."""
        return self._play(self.topic)

    def _choose_topic(self, topic: 'str | None') -> str:
        candidates = sorted({channel.topic for channel in self._files.channels
                             if self._channels(channel.topic)})
        if topic in candidates:
            return topic
        if topic is not None or not candidates:
            kinds = listed({f'{channel.topic} ({channel.kind}, {channel.encoding})'
                            for channel in self._files.channels})
            raise BagError(f'{self.path}: no joint states in CDR or ROS 1 encoding'
                           f'{f" on {topic}" if topic else ""}; it has {kinds or "no messages"}')
        fitting = [name for name in candidates if sides_of(self._peek(name), self.arm)]
        if USUAL_TOPIC in fitting:
            return USUAL_TOPIC
        if len(fitting) > 1:
            options = ' or '.join(f'--topic {name}' for name in fitting)
            raise BagError(f"{self.path}: several topics have an arm's joints: choose {options}")
        return fitting[0] if fitting else candidates[0]

    def _channels(self, topic: str) -> list[Channel]:
        return [channel for channel in self._files.channels
                if channel.topic == topic and channel.kind == JOINT_STATE
                and channel.encoding in _READABLE]

    def _peek(self, topic: str) -> set[str]:
        """Return joints on a topic: of the first messages, and until there are an arm's."""
        if topic not in self._names:
            names = self._names[topic] = set()
            for i, state in enumerate(self._play(topic)):
                names.update(state.names)
                if i >= _PEEK and sides_of(names, self.arm):
                    break
        return self._names[topic]

    def _play(self, topic: str) -> Iterator[JointState]:
        channels = self._channels(topic)
        missing = sum(channel.count for channel in channels)
        messages = self._files.messages(channels)
        while True:
            try:
                channel, received_ns, raw = next(messages)
            except StopIteration:
                break
            except Exception as error:  # a damaged file makes the libraries raise anything
                raise bag_error(self.path, error) from None
            missing -= 1
            yield self._state(channel, received_ns, raw)
        if missing > 0:  # a library may skip records that it does not know
            raise BagError(f'{self.path}: {missing} messages on {topic} are missing: the bag is '
                           'damaged')

    def _state(self, channel: Channel, received_ns: int, raw: bytes) -> JointState:
        try:
            message = _decode(channel.encoding, raw)
        except Exception as error:  # a damaged message makes the parser raise anything
            raise BagError(f'{self.path}: {channel.topic}: the message received at {received_ns} '
                           f'ns is not a joint state ({error})') from None
        stamp = message.header.stamp
        return JointState(stamp.sec * 10**9 + stamp.nanosec, message.name, message.position,
                          message.velocity, message.effort, received_ns)


@lru_cache
def _types(store: Stores) -> Typestore:
    return get_typestore(store)


def _decode(encoding: str, raw: bytes) -> Any:
    if encoding == 'ros1':
        return _types(Stores.ROS1_NOETIC).deserialize_ros1(raw, JOINT_STATE)
    for padding in _PADDING:
        try:
            return _types(Stores.ROS2_JAZZY).deserialize_cdr(raw[:len(raw) - padding], JOINT_STATE)
        except SerdeError as error:  # a message of another length
            problem = error
    raise problem

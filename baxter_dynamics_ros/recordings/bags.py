"""Joint states of one arm in a bag of ROS 1 or ROS 2, in the order of recording."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import lru_cache
import os
from pathlib import Path
from typing import Any, NamedTuple

from rosbags.serde import SerdeError
from rosbags.typesys import get_typestore, Stores
from rosbags.typesys.store import Typestore

from .bag_files import BagFiles, Channel
from .choice import choose_arm, choose_topic, JOINT_STATE, READABLE, sides_of
from .diagnosis import bag_error, BagError, refuse_unfinished
from ..model.arrays import Array

_PEEK = 1000  # messages read to find the arms on a topic; more until there is one
_PADDING = (0, 4, 8)  # bytes that some writers append to a message


class JointState(NamedTuple):
    """A joint state as recorded, with a usable stamp."""

    stamp_ns: int  # the header's, or received_ns where that is zero or constant [ns]
    names: Sequence[str]  # joints
    position: Array  # [rad]; as long as names, unless the message is malformed
    velocity: Array  # [rad/s]; as long, or empty
    effort: Array  # [N m]; as long, or empty
    received_ns: int  # time of recording [ns]


class BagRecording:
    """
    Joint states of one arm in a bag; a context manager that keeps the bag open.

    Iterating yields each :class:`JointState` on the topic, any number of times. Memory does not
    grow with the bag, except for the index of a ROS 1 bag.

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
    path : Path
        The bag.
    name : str
        Name of its folder or file, without ending.
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
        self._requested = (topic, arm)
        self._names: dict[str, set[str]] = {}  # topic -> joints
        self._is_stamp_constant = False
        self._unstamped = 0  # messages of the latest iteration

    def __enter__(self) -> 'BagRecording':
        """Open the bag and find topic and arm."""
        try:
            refuse_unfinished(self.path)
            self._files = BagFiles(self.path)
        except Exception as error:  # a damaged file makes the libraries raise anything
            raise bag_error(self.path, error) from None
        try:
            self._choose(*self._requested)
        except BaseException:
            self._files.close()
            raise
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Close the bag."""
        self._files.close()

    def __iter__(self) -> Iterator[JointState]:
        """Yield each :class:`JointState` of the topic."""
        self._unstamped = 0
        for state in self._play(self.topic):
            if self._is_stamp_constant or not state.stamp_ns:
                self._unstamped += not state.stamp_ns
                state = state._replace(stamp_ns=state.received_ns)
            yield state

    @property
    def remarks(self) -> list[str]:
        """Return remarks on the stamps, once the recording is read."""
        used = 'using times of recording, which blurs the accelerations'
        if self._is_stamp_constant:
            return [f'all stamps are the same: {used}']
        if self._unstamped:
            return [f'{self._unstamped} of {self.count} messages have no stamp: {used}']
        return []

    def _choose(self, topic: 'str | None', arm: 'str | None') -> None:
        topics: dict[str, set[str]] = {}
        for channel in self._files.channels:
            note = '' if channel.encoding in READABLE else f' ({channel.encoding})'
            topics.setdefault(channel.topic, set()).add(channel.kind + note)
        self.topic = choose_topic(self.path, topics, topic, arm,
                                  lambda name: self._peek(name, arm))
        self.arm = choose_arm(f'{self.path}: {self.topic}', self._peek(self.topic, arm), arm)
        self.count = sum(channel.count for channel in self._channels(self.topic))

    def _channels(self, topic: str) -> list[Channel]:
        return [channel for channel in self._files.channels
                if channel.topic == topic and channel.kind == JOINT_STATE
                and channel.encoding in READABLE]

    def _peek(self, topic: str, arm: 'str | None') -> set[str]:
        """Return joints on a topic: of the first messages, and until there are an arm's."""
        if topic not in self._names:
            names = self._names[topic] = set()
            stamps = []
            for i, state in enumerate(self._play(topic)):
                names.update(state.names)
                if sides_of(set(state.names)):
                    stamps.append(state.stamp_ns)
                if i >= _PEEK and sides_of(names, arm):
                    break
            self._is_stamp_constant = len(stamps) > 1 and {*stamps} == {stamps[0]} != {0}
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
                           'damaged, or its metadata belong to another one')

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
        with suppress(SerdeError):  # a message of another length
            return _types(Stores.ROS2_JAZZY).deserialize_cdr(raw[:len(raw) - padding], JOINT_STATE)
    return _types(Stores.ROS2_JAZZY).deserialize_cdr(raw, JOINT_STATE)  # raises

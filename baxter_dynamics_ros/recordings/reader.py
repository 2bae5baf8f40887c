"""Recordings of any kind: bags of ROS 1 and ROS 2, and arrays in .npz and .csv files."""

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias

from rosbags.serde import SerdeError
from rosbags.typesys import get_typestore, Stores
from rosbags.typesys.store import Typestore

from .array_files import ArrayRecording, read_arrays
from .bag_files import bag_error, BagFiles, Channel
from .recording import (BagError, choose_arm, JOINT_STATE, JointState, listed, sides_of,
                        USUAL_TOPIC)

_PEEK = 1000  # messages read to find the arms on a topic; more until there is one
_PADDING = (0, 4, 8)  # bytes that some writers append to a message

AnyRecording: TypeAlias = 'BagRecording | ArrayRecording'
Recordings: TypeAlias = Sequence[AnyRecording]


def open_recordings(paths: Iterable[str | Path], topic: str | None = None,
                    arm: str | None = None) -> list[AnyRecording]:
    """
    Return the recordings in some files, each to be opened by ``with`` before it is read.

    A bag is one recording; .npz and .csv files are read at once, see :mod:`.array_files`. The
    topic is by default the robot's usual one, or the only one with an arm's joints, and the arm
    the only one in the recording. Raises BagError if a path is missing or neither file nor
    folder, or a file of arrays is malformed; other errors are raised when a recording is opened.
    """
    recordings: list[AnyRecording] = []
    for path in map(Path, paths):
        try:
            path.stat()
            if not path.is_file() and not path.is_dir():
                raise BagError(f'{path}: is neither a file nor a folder')
        except (OSError, BagError) as error:
            raise bag_error(path, error) from None
        recordings += (read_arrays(path, arm) if path.suffix in ('.npz', '.csv')
                       else [BagRecording(path, topic, arm)])
    return recordings


class BagRecording:
    """
    Joint states of one arm in a bag; a context manager that keeps the bag open.

    Iterating yields each :class:`~.recording.JointState` on the topic, any number of times, and
    raises BagError at a damaged place. Memory does not grow with the bag, except for an MCAP file
    without an index and the index of a ROS 1 bag.
    """

    topic: str  # known once it is open, as are the next two
    arm: str
    count: int  # joint states on the topic

    def __init__(self, path: Path, topic: 'str | None' = None, arm: 'str | None' = None) -> None:
        self.path = path
        name = path.resolve().name
        self.name = name if path.is_dir() else Path(name.removesuffix('.zstd')).stem
        self._wanted = topic, arm

    def __enter__(self) -> 'BagRecording':
        """Open the bag and find topic and arm."""
        try:
            self._files = BagFiles(self.path)
        except Exception as error:  # a damaged file makes the libraries raise anything
            raise bag_error(self.path, error) from None
        try:
            self._choose(*self._wanted)
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

    def _choose(self, topic: 'str | None', arm: 'str | None') -> None:
        """Set topic and arm."""
        candidates = sorted({channel.topic for channel in self._files.channels
                             if topic in (None, channel.topic) and _is_readable(channel)})
        if not candidates:
            kinds = listed({f'{channel.topic} ({channel.kind}, {channel.encoding})'
                            for channel in self._files.channels})
            raise BagError(f'{self.path}: no joint states in CDR or ROS 1 encoding'
                           f'{f" on {topic}" if topic else ""}; it has {kinds or "no messages"}')
        names = {each: self._joints(each, arm) for each in candidates}
        fitting = [each for each in candidates if sides_of(names[each], arm)]
        if USUAL_TOPIC not in fitting and len(fitting) > 1:
            options = ' or '.join(f'--topic {each}' for each in fitting)
            raise BagError(f"{self.path}: several topics have an arm's joints: choose {options}")
        self.topic = USUAL_TOPIC if USUAL_TOPIC in fitting else (fitting or candidates)[0]
        self.arm = choose_arm(f'{self.path}: {self.topic}', names[self.topic], arm)

    def _channels(self, topic: str) -> list[Channel]:
        return [channel for channel in self._files.channels
                if channel.topic == topic and _is_readable(channel)]

    def _joints(self, topic: str, arm: 'str | None') -> set[str]:
        """Return joints on a topic: of the first messages, and until there are an arm's."""
        names: set[str] = set()
        for i, state in enumerate(self._play(topic)):
            names.update(state.names)
            if i >= _PEEK and sides_of(names, arm):
                break
        return names

    def _play(self, topic: str) -> Iterator[JointState]:
        missing = sum(channel.count for channel in self._channels(topic))
        try:
            for channel, received_ns, raw in self._files.messages(topic):
                if _is_readable(channel):
                    missing -= 1
                    yield self._state(channel, received_ns, raw)
        except Exception as error:  # a damaged file makes the libraries raise anything
            raise bag_error(self.path, error) from None
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


def _is_readable(channel: Channel) -> bool:
    return channel.kind == JOINT_STATE and channel.encoding in ('cdr', 'ros1')


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

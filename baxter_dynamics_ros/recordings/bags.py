"""Recordings in bags of ROS 1 and ROS 2, and a writer of joint states to new bags."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, ExitStack
import os
from pathlib import Path
import struct
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.serde import SerdeError
from rosbags.typesys import Stores
import zstandard

from .bag_files import Channel, JOINT_STATE, open_bag, reading, type_store
from .recording import (BagError, choose_arm, read_arrays, RecordedState, Recording, sides_of,
                        USUAL_TOPIC)
from ..estimation.predictor import Predictor
from ..estimation.settings import PredictorSettings
from ..files import staged
from ..model import ArrayLike, first_names

_PEEK = 1000  # messages read to find the arms on a topic; more until there is one
_PADDING = (0, 4, 8)  # bytes that some writers append to a message
_decompress = zstandard.ZstdDecompressor().decompress


def open_recordings(paths: Iterable[str | Path], topic: str | None = None,
                    arm: str | None = None, prefix: str = '') -> list[Recording]:
    """
    Return the recordings in bags and files of arrays, each to be opened by ``with``.

    The topic is by default the robot's usual one, or the only one with an arm's joints, and the
    arm the only one in the recording; joints without a side are of the right arm. The names of
    joints have a prefix, as in the settings. Raises BagError if a path is no file or folder or a
    file of arrays is malformed; a bag is read when opened.
    """
    recordings: list[Recording] = []
    for path in map(Path, paths):
        with reading(path):
            path.stat()
            if not path.is_file() and not path.is_dir():
                raise BagError(f'{path}: is neither a file nor a folder')
            recordings += (read_arrays(path, arm, prefix) if path.suffix in ('.npz', '.csv')
                           else [BagRecording(path, topic, arm, prefix)])
    return recordings


class BagRecording(Recording):
    """
    Recording in a bag; topic, arm and count are known once it is open.

    Iterating raises BagError at a damaged place. Memory does not grow with the bag, except for an
    MCAP file without an index and the index of a ROS 1 bag.
    """

    def __init__(self, path: Path, topic: 'str | None' = None, arm: 'str | None' = None,
                 prefix: str = '') -> None:
        self.path = path
        name = path.resolve().name
        self.name = name if path.is_dir() else Path(name.removesuffix('.zstd')).stem
        self._wanted = topic, arm, prefix

    def __enter__(self) -> 'BagRecording':
        """Open the bag and find topic and arm."""
        with ExitStack() as stack:
            with reading(self.path):
                self._files = open_bag(self.path, stack)
            self._channels = [channel for file in self._files.values()
                              for channel in file.channels.values() if channel.count]
            self._choose(*self._wanted)
            self._close = stack.pop_all().close
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Close the bag."""
        self._close()

    def __iter__(self) -> Iterator[RecordedState]:
        """Yield each joint state of the topic."""
        return self._play(self.topic)

    def _choose(self, topic: 'str | None', arm: 'str | None', prefix: str) -> None:
        """Set topic, arm and count."""
        candidates = sorted({channel.topic for channel in self._channels
                             if topic in (None, channel.topic) and channel.is_readable})
        if not candidates:
            kinds = first_names(sorted({
                f'{channel.topic} ({channel.kind}, {channel.encoding})'
                for channel in self._channels}))
            raise BagError(f'{self.path}: no joint states in CDR or ROS 1 encoding'
                           f'{f" on {topic}" if topic else ""}; it has {kinds or "no messages"}')
        names = {each: self._joints(each, arm, prefix) for each in candidates}
        fitting = [each for each in candidates if sides_of(names[each], arm, prefix)]
        if USUAL_TOPIC not in fitting and len(fitting) > 1:
            options = ' or '.join(f'--topic {each}' for each in fitting)
            raise BagError(f"{self.path}: several topics have an arm's joints: choose {options}")
        self.topic = USUAL_TOPIC if USUAL_TOPIC in fitting else (fitting or candidates)[0]
        self.arm = choose_arm(f'{self.path}: {self.topic}', names[self.topic], arm, prefix)
        self.count = self._count(self.topic)

    def _count(self, topic: str) -> int:
        return sum(channel.count for channel in self._channels
                   if channel.topic == topic and channel.is_readable)

    def _joints(self, topic: str, arm: 'str | None', prefix: str) -> set[str]:
        """Return the joints in a topic's first messages, and in more until an arm is found."""
        names: set[str] = set()
        for i, state in enumerate(self._play(topic)):
            names.update(state.names)
            if i >= _PEEK and sides_of(names, arm, prefix):
                break
        return names

    def _play(self, topic: str) -> Iterator[RecordedState]:
        missing = self._count(topic)
        for path, file in self._files.items():
            with reading(path):
                for channel, received_ns, raw in file.messages(topic):
                    if channel.is_readable:
                        missing -= 1
                        yield self._state(channel, received_ns, raw)
        if missing > 0:  # a library may skip records that it does not know
            raise BagError(f'{self.path}: {missing} messages on {topic} are missing: the bag is '
                           'damaged')

    def _state(self, channel: Channel, received_ns: int, raw: bytes) -> RecordedState:
        try:
            message = _decode(channel.encoding, raw)
        except Exception as error:  # a damaged message makes the parser raise anything
            raise BagError(f'{self.path}: {channel.topic}: the message received at {received_ns} '
                           f'ns is not a joint state ({error})') from None
        stamp = message.header.stamp
        return RecordedState(stamp.sec * 10**9 + stamp.nanosec, message.name, message.position,
                             message.velocity, message.effort, received_ns)


def _decode(encoding: str, raw: bytes) -> Any:
    if encoding == 'ros1':
        return type_store(Stores.ROS1_NOETIC).deserialize_ros1(raw, JOINT_STATE)
    if raw.startswith(zstandard.FRAME_HEADER):  # CDR begins with 0
        raw = _decompress(raw)
    decode = type_store(Stores.ROS2_JAZZY).deserialize_cdr
    for padding in _PADDING:
        try:
            return decode(raw[:len(raw) - padding], JOINT_STATE)
        except SerdeError as error:  # a message of another length
            problem = error
    raise problem


class BagWriter:
    """Writer of joint states to an open bag; see :func:`new_bag`."""

    def __init__(self, path: Path, bag: Writer) -> None:
        self.path = path
        self._bag = bag
        self._connections: dict[str, Any] = {}  # topic to connection

    def joint_state(self, topic: str, stamp_ns: int, names: Iterable[str], position: ArrayLike,
                    velocity: ArrayLike = (), effort: ArrayLike = (),
                    received_ns: int | None = None, frame: str = '') -> None:
        """
        Write a joint state with values in rad, rad/s and N m, which may be empty.

        The time of recording, received_ns, is the stamp by default; frame is ``frame_id``.
        """
        store = type_store(Stores.ROS2_JAZZY)
        try:
            message = store.types[JOINT_STATE](
                store.types['std_msgs/msg/Header'](
                    store.types['builtin_interfaces/msg/Time'](*divmod(stamp_ns, 10**9)), frame),
                list(names), *(np.ascontiguousarray(array, dtype=float)
                               for array in (position, velocity, effort)))
            raw = store.serialize_cdr(message, JOINT_STATE)
            if topic not in self._connections:
                self._connections[topic] = self._bag.add_connection(
                    topic, JOINT_STATE, typestore=store)
            self._bag.write(self._connections[topic],
                            stamp_ns if received_ns is None else received_ns, raw)
        except (OverflowError, WriterError, struct.error) as error:
            raise BagError(f'{self.path}: {topic}: cannot be written ({error})') from None


@contextmanager
def new_bag(path: Path) -> Iterator[BagWriter]:
    """
    Provide a writer of a new rosbag2 folder (MCAP), which appears when the block succeeds.

    Raises BagError, also from the writer, if the folder exists or cannot be written.
    """
    _refuse_existing(path)
    if not os.path.isdir(path.parent):
        raise BagError(f'{path}: no folder {path.parent}')
    with staged(path.parent, path.name) as stage:
        with Writer(stage / path.name, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
            yield BagWriter(path, bag)
        _refuse_existing(path)  # it may have been created meanwhile


def _refuse_existing(path: Path) -> None:
    if os.path.lexists(path):
        raise BagError(f'{path}: exists; choose a new folder or remove it first')


def save_predictions(recording: Recording, settings: PredictorSettings, writer: BagWriter,
                     node: str) -> None:
    """Write the efforts, residuals and their deviations that a node would publish."""
    predictor = Predictor(settings, external=True)
    names = predictor.stream.selector.names
    for state in recording:
        for result, efforts in predictor.handle(*state).efforts():
            for topic, effort in efforts.items():
                writer.joint_state(f'/{node.strip("/")}/{topic}', result.stamp_ns, names, result.q,
                                   result.qd, effort, state.received_ns, settings.frame_id)

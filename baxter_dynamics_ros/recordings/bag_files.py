"""Files of a bag, read by the libraries mcap and rosbags: channels, and messages as recorded."""

from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from mcap.reader import NonSeekingReader, SeekingReader
from rosbags.interfaces import ConnectionExtRosbag2
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader
import zstandard

from .bag_errors import read_metadata, refuse_unfinished


class Channel(NamedTuple):
    """Messages of one type on a topic, from one publisher, in one file."""

    topic: str
    kind: str  # type as ROS 2 writes it, 'package/msg/Name'
    encoding: str  # 'cdr', 'ros1' or another one
    count: int  # type: ignore[assignment]  # messages; a tuple has a method of that name
    number: int  # unique in the file
    file: int = 0  # index of the file in the bag


class BagFiles:
    """
    Open files of a bag: a rosbag2 folder, one of its files (compressed or not), or a ROS 1 bag.

    The libraries raise exceptions of many types for a damaged file.
    """

    def __init__(self, path: Path) -> None:
        self.channels: list[Channel] = []  # with messages
        self._files: list[_McapFile | _RosbagsFile] = []
        names, self._is_compressed = read_metadata(path) if path.is_dir() else ([path], False)
        with ExitStack() as stack:
            for name in names:
                self._open(path / name, stack)
            self._stack = stack.pop_all()

    def close(self) -> None:
        """Close the files."""
        self._stack.close()

    def messages(self, channels: Collection[Channel]) -> Iterator[tuple[Channel, int, bytes]]:
        """Yield channel, time of recording [ns] and data of each message, file by file."""
        decompress = zstandard.ZstdDecompressor().decompress
        for i, file in enumerate(self._files):
            chosen = {channel.number: channel for channel in channels if channel.file == i}
            if not chosen:
                continue
            for id_, received_ns, raw in file.messages(chosen):
                yield chosen[id_], received_ns, decompress(raw) if self._is_compressed else raw

    def _open(self, path: Path, stack: ExitStack) -> None:
        refuse_unfinished(path)
        folder = Path(stack.enter_context(TemporaryDirectory()))
        if path.suffix == '.zstd':
            with path.open('rb') as source, (folder / path.stem).open('wb') as target:
                zstandard.ZstdDecompressor().copy_stream(source, target)
            path = folder / path.stem
        elif path.suffix == '.db3':  # rosbags opens files by URIs, in which ?, # and % are syntax
            (folder / 'link.db3').symlink_to(path.resolve())
            path = folder / 'link.db3'
        file = (_McapFile if path.suffix == '.mcap' else _RosbagsFile)(path, stack)
        self.channels += [channel._replace(file=len(self._files)) for channel in file.channels
                          if channel.count]
        self._files.append(file)


class _RosbagsFile:
    """An SQLite file or a ROS 1 bag."""

    def __init__(self, path: Path, stack: ExitStack) -> None:
        is_ros1 = path.suffix in ('.bag', '.active')
        self._reader: Any = (Ros1Reader if is_ros1 else Ros2Reader)(path)
        self._reader.open()
        stack.callback(self._reader.close)
        self.channels = [
            Channel(each.topic, each.msgtype, each.ext.serialization_format
                    if isinstance(each.ext, ConnectionExtRosbag2) else 'ros1',
                    each.msgcount, each.id)
            for each in self._reader.connections]

    def messages(self, ids: Collection[int]) -> Iterator[tuple[int, int, bytes]]:
        connections = [each for each in self._reader.connections if each.id in ids]
        for connection, received_ns, raw in self._reader.messages(connections):
            yield connection.id, received_ns, raw


class _McapFile:
    """An MCAP file; one without an index is sorted in memory."""

    def __init__(self, path: Path, stack: ExitStack) -> None:
        self._stream = stack.enter_context(path.open('rb'))
        self._limit = path.stat().st_size  # of a record [bytes]
        self._reader: Any = SeekingReader
        summary = self._open().get_summary()
        if _is_complete(summary):
            counts = summary.statistics.channel_message_counts
            found = {id_: (summary.channels[id_], summary.schemas.get(
                summary.channels[id_].schema_id)) for id_ in counts}
        else:
            self._reader = NonSeekingReader
            found, counts = {}, Counter()
            for schema, channel, _ in self._open().iter_messages(log_time_order=False):
                found[channel.id] = channel, schema
                counts[channel.id] += 1
        self.channels = [
            Channel(channel.topic, _ros2_name(schema.name) if schema else 'no type',
                    channel.message_encoding, counts[id_], id_)
            for id_, (channel, schema) in found.items()]

    def messages(self, ids: Collection[int]) -> Iterator[tuple[int, int, bytes]]:
        topics = {channel.topic for channel in self.channels if channel.number in ids}
        for _, channel, message in self._open().iter_messages(topics):
            if channel.id in ids:
                yield channel.id, message.log_time, message.data

    def _open(self) -> Any:
        self._stream.seek(0)
        return self._reader(self._stream, True, record_size_limit=self._limit)


def _is_complete(summary: Any) -> bool:
    """Return whether the summary of an MCAP file has an index, all counts and all types."""
    if summary is None or summary.statistics is None or not summary.chunk_indexes:
        return False
    counts = summary.statistics.channel_message_counts
    return sum(counts.values()) == summary.statistics.message_count and all(
        id_ in summary.channels and summary.channels[id_].schema_id in {0, *summary.schemas}
        for id_ in counts)


def _ros2_name(name: str) -> str:
    """Return the name of a type as ROS 2 writes it; ROS 1 writes 'package/Name'."""
    package, _, rest = name.partition('/')
    return f'{package}/msg/{rest}' if rest and '/' not in rest else name

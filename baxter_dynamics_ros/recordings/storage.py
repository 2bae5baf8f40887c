"""Files of a bag, whatever their format: channels, and messages as recorded."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
import stat
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Protocol

from rosbags.interfaces import Connection, ConnectionExtRosbag2
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader
import yaml
import zstandard

from .mcap_file import Channel, McapFile

ZSTD = '.zstd'
_LARGEST = 1 << 24  # of metadata.yaml [bytes]


class Storage(Protocol):
    """An open file or folder of a bag."""

    channels: list[Channel]

    def messages(self, channels: list[Channel]) -> Iterator[tuple[Channel, int, bytes]]:
        """Yield channel, time of recording [ns] and data of each message, by that time."""

    def close(self) -> None:
        """Close the files."""


class NotAFileError(Exception):
    """A path is neither a regular file nor a folder."""


def open_storage(path: Path) -> Storage:
    """
    Open a bag: a rosbag2 folder, one of its files (compressed or not), or a ROS 1 bag.

    Raises
    ------
    NotAFileError
        If the path is a pipe, a device or a socket.
    Exception
        Whatever the libraries raise for a damaged file.

    """
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        return _Folder(path)
    if not stat.S_ISREG(mode):
        raise NotAFileError(f'{path}: is neither a file nor a folder')
    if path.suffix == ZSTD:
        return _Compressed(path)
    if path.suffix == '.mcap':
        return McapFile(path)
    return _RosbagsFile(path)


class _RosbagsFile:
    """An SQLite file or a ROS 1 bag, read by the rosbags library."""

    def __init__(self, path: Path) -> None:
        is_ros1 = path.suffix in ('.bag', '.active')
        self._reader: Any = (Ros1Reader if is_ros1 else Ros2Reader)(path)
        self._reader.open()
        self._connections: dict[int, Connection] = {
            connection.id: connection for connection in self._reader.connections}
        self.channels = [
            Channel(connection.id, connection.topic, connection.msgtype,
                    connection.ext.serialization_format
                    if isinstance(connection.ext, ConnectionExtRosbag2) else 'ros1',
                    connection.msgcount)
            for connection in self._connections.values() if connection.msgcount]

    def close(self) -> None:
        self._reader.close()

    def messages(self, channels: list[Channel]) -> Iterator[tuple[Channel, int, bytes]]:
        known = {channel.key: channel for channel in channels}
        for connection, received_ns, raw in self._reader.messages(
                [self._connections[id_] for id_ in known]):
            yield known[connection.id], received_ns, raw


class _Compressed:
    """A file that was compressed as a whole; decompressed into a temporary one."""

    def __init__(self, path: Path) -> None:
        with ExitStack() as stack:
            folder = stack.enter_context(TemporaryDirectory())
            plain = Path(folder) / path.stem
            with path.open('rb') as source, plain.open('wb') as target:
                zstandard.ZstdDecompressor().copy_stream(source, target)
            self._inner = open_storage(plain)
            stack.callback(self._inner.close)
            self._stack = stack.pop_all()
        self.channels = self._inner.channels
        self.messages = self._inner.messages

    def close(self) -> None:
        self._stack.close()


class Metadata(NamedTuple):
    """What metadata.yaml says of a bag's files."""

    files: list[str]  # names in the folder
    is_compressed: bool  # message by message
    counts: dict[str, int]  # topic -> messages


def read_metadata(folder: Path) -> Metadata:
    """
    Return the metadata of a rosbag2 folder.

    Raises
    ------
    OSError, ValueError, LookupError, TypeError, AttributeError, YAMLError
        If it is missing or something else.

    """
    path = folder / 'metadata.yaml'
    status = path.stat()
    if not stat.S_ISREG(status.st_mode) or status.st_size > _LARGEST:
        raise ValueError('not a file of that kind')
    loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
    content = yaml.load(path.read_bytes(), loader)['rosbag2_bagfile_information']
    topics = content['topics_with_message_count']
    return Metadata(
        [Path(name).name for name in content['relative_file_paths']],
        str(content.get('compression_mode') or '').lower() == 'message',
        {topic['topic_metadata']['name']: int(topic['message_count']) for topic in topics})


class _Folder:
    """A rosbag2 folder: its files one after the other."""

    def __init__(self, path: Path) -> None:
        metadata = read_metadata(path)
        self._is_compressed = metadata.is_compressed
        self._parts: list[tuple[Storage, dict[int, Channel]]] = []
        self.channels: list[Channel] = []
        with ExitStack() as stack:
            for name in metadata.files:
                part = open_storage(path / name)
                stack.callback(part.close)
                renamed = {channel.key: channel._replace(key=len(self.channels) + i)
                           for i, channel in enumerate(part.channels)}
                self._parts.append((part, renamed))
                self.channels += renamed.values()
            self._stack = stack.pop_all()
        self._promise(metadata.counts)

    def _promise(self, counts: dict[str, int]) -> None:
        """Let a topic's first channel miss the messages that only metadata.yaml knows."""
        for topic, count in counts.items():
            found = [channel for channel in self.channels if channel.topic == topic]
            missing = count - sum(channel.count for channel in found)
            if found and missing > 0:
                place = self.channels.index(found[0])
                self.channels[place] = found[0]._replace(count=found[0].count + missing)

    def close(self) -> None:
        self._stack.close()

    def messages(self, channels: list[Channel]) -> Iterator[tuple[Channel, int, bytes]]:
        wanted = {channel.key: channel for channel in channels}
        decompress = zstandard.ZstdDecompressor().decompress
        for part, renamed in self._parts:
            chosen = [channel for channel in part.channels if renamed[channel.key].key in wanted]
            if not chosen:
                continue
            for channel, received_ns, raw in part.messages(chosen):
                yield (wanted[renamed[channel.key].key], received_ns,
                       decompress(raw) if self._is_compressed else raw)

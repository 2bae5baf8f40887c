"""Files of a bag, read by mcap and rosbags, or the reason why they cannot be read."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
from functools import lru_cache
import os
from pathlib import Path
import re
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, TypeAlias

from mcap.reader import NonSeekingReader, SeekingReader
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2 import Reader as Ros2Reader
from rosbags.typesys import get_typestore
import yaml
import zstandard

from .recording import BagError

JOINT_STATE = 'sensor_msgs/msg/JointState'

_ROS1_TYPE = re.compile('^([^/]+)/([^/]+)$')  # package/Name
_METADATA = 'metadata.yaml'
_KILLED = ' (was the recorder killed?)'

type_store = lru_cache(get_typestore)  # which takes 0.1 s


class Channel(NamedTuple):
    """Messages of one type on a topic, from one publisher, in one file."""

    topic: str
    kind: str  # type as ROS 2 writes it, 'package/msg/Name'
    encoding: str  # 'cdr', 'ros1' or another one
    count: int  # type: ignore[assignment]  # messages; a tuple has a method of that name

    @property
    def is_readable(self) -> bool:
        """Return whether its messages are joint states in a known encoding."""
        return self.kind == JOINT_STATE and self.encoding in ('cdr', 'ros1')


Messages = Iterator[tuple[Channel, int, bytes]]  # channel, time of recording [ns], data
BagFile: TypeAlias = '_McapFile | _RosbagsFile'


class _Kind(NamedTuple):
    start: bytes  # of every such file
    noun: str
    repair: str = ''  # command


_MCAP = _Kind(b'\x89MCAP', 'an MCAP file', 'mcap recover {} -o repaired.mcap')
_ROS1 = _Kind(b'#ROSBAG V2.0', 'a ROS 1 bag of version 2.0', 'rosbag reindex {}')
_KINDS = {'.mcap': _MCAP, '.bag': _ROS1, '.active': _ROS1,
          '.db3': _Kind(b'SQLite format 3\0', 'an SQLite file',
                        'sqlite3 {} .recover | sqlite3 repaired.db3'),
          '.zstd': _Kind(zstandard.FRAME_HEADER, 'a zstd file')}


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn exceptions, which the libraries raise of any type for a damaged file, into BagError."""
    try:
        yield
    except BagError:
        raise
    except PermissionError as error:
        raise BagError(f'{error.filename}: permission denied; make it readable') from None
    except Exception as error:
        if isinstance(error, (FileNotFoundError, NotADirectoryError)) and not path.exists():
            raise BagError(f'{path}: no such file or folder') from None
        of_system = getattr(error, 'strerror', None)
        reason = of_system or ' '.join(str(error).split()).rstrip('.') or type(error).__name__
        repair = _KINDS[path.suffix].repair if path.suffix in _KINDS else ''
        advice = (f'; if it is damaged: `{repair.format(path)}`' if repair else
                  '' if of_system else '; is it complete?')
        raise BagError(f'{path}: cannot be read ({reason:.200}){advice}') from None


def open_bag(path: Path, stack: ExitStack) -> dict[Path, BagFile]:
    """
    Return the files of a bag, open until the stack closes.

    A bag is a rosbag2 folder, one of its files (compressed or not), or a ROS 1 bag.
    """
    files = _files_of(path) if path.is_dir() else [path]
    if not path.is_dir() and path.suffix not in _KINDS:
        raise BagError(f'{path}: ' + (
            f'is part of a bag: name the folder {path.parent}'
            if (path.parent / _METADATA).exists() else
            'is not a bag: expected a rosbag2 folder, or a file ending in .mcap, .mcap.zstd, '
            '.db3, .bag, .npz or .csv'))
    return {file: _open(file, stack) for file in files}


def _files_of(folder: Path) -> list[Path]:
    """Return the files of a rosbag2 folder."""
    metadata = folder / _METADATA
    if not metadata.exists():
        raise BagError(f'{folder}: {_without_metadata(folder)}')
    text = metadata.read_bytes()
    try:
        names = yaml.safe_load(text)['rosbag2_bagfile_information']['relative_file_paths']
        files = [folder / Path(name).name for name in names]
    except (yaml.YAMLError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        raise BagError(f'{metadata}: is not the metadata of a bag: `ros2 bag reindex {folder}` '
                       'writes a new one') from None
    missing = ', '.join(file.name for file in files if not file.exists())
    if missing:
        raise BagError(f'{folder}: {_METADATA} lists files that are missing: {missing}; restore '
                       f'them, or remove them from the list: `ros2 bag reindex {folder}`')
    return files


def _without_metadata(folder: Path) -> str:
    """Return why a folder without metadata is refused; raise BagError if a file is damaged."""
    files = sorted(file for file in folder.iterdir() if file.suffix in _KINDS and file.is_file())
    plain = [file for file in files if file.suffix in ('.mcap', '.db3')]
    for file in plain:
        _check(file)
    if plain:
        storage = 'mcap' if plain[0].suffix == '.mcap' else 'sqlite3'
        return f'has no {_METADATA}{_KILLED}: `ros2 bag reindex -s {storage} {folder}` writes it'
    bags = sorted(bag.name for bag in (*files, *(
        path.parent for path in folder.glob(f'*/{_METADATA}'))))
    choice = f'; choose one of the bags in it: {", ".join(bags)}' if bags else ''
    return f'{"has" if files else "is not a bag: it has"} no {_METADATA}{choice}'


def _check(file: Path) -> None:
    """Raise BagError if a file is empty, of another kind than its name says, or incomplete."""
    if file.suffix not in _KINDS or file.exists() and not file.is_file():
        raise BagError(f'{file}: is not a file of a bag')
    kind, log = _KINDS[file.suffix], file.with_name(file.name + '-wal')
    if file.suffix == '.db3' and log.is_file() and log.stat().st_size:
        raise BagError(f'{file}: its last messages are in {log.name}{_KILLED}: '
                       f'`sqlite3 {file} "PRAGMA wal_checkpoint(TRUNCATE)"` adds them')
    with file.open('rb') as stream:
        start = stream.read(16)
        stream.seek(-len(start), os.SEEK_END)
        end = stream.read()
    if not start:
        raise BagError(f'{file}: is empty')
    if not start.startswith(kind.start):
        raise BagError(f'{file}: is not {kind.noun}, despite its name')
    if kind is _MCAP and end[8:] != start[:8]:
        raise BagError(f'{file}: is truncated{_KILLED}: `{kind.repair.format(file)}`')


def _open(path: Path, stack: ExitStack) -> BagFile:
    with reading(path):
        _check(path)
        folder = Path(stack.enter_context(TemporaryDirectory()))
        if path.suffix == '.zstd':
            with path.open('rb') as source, (folder / path.stem).open('wb') as target:
                zstandard.ZstdDecompressor().copy_stream(source, target)
            path = folder / path.stem
        elif path.suffix == '.db3':  # rosbags opens files by URIs, in which ?, # and % are syntax
            (folder / 'link.db3').symlink_to(path.resolve())
            path = folder / 'link.db3'
        return (_McapFile if path.suffix == '.mcap' else _RosbagsFile)(path, stack)


class _RosbagsFile:
    """An SQLite file or a ROS 1 bag."""

    def __init__(self, path: Path, stack: ExitStack) -> None:
        reader: Any = Ros1Reader if path.suffix in ('.bag', '.active') else Ros2Reader
        self._reader = stack.enter_context(reader(path))
        self.channels = {each.id: Channel(
            each.topic, each.msgtype, getattr(each.ext, 'serialization_format', 'ros1'),
            each.msgcount) for each in self._reader.connections}

    def messages(self, topic: str) -> Messages:
        connections = [each for each in self._reader.connections if each.topic == topic]
        # Without connections, rosbags yields all messages.
        for connection, received_ns, raw in connections and self._reader.messages(connections):
            yield self.channels[connection.id], received_ns, raw


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
        self.channels = {
            id_: Channel(channel.topic, _ROS1_TYPE.sub(r'\1/msg/\2', schema.name) if schema
                         else 'no type', channel.message_encoding, counts[id_])
            for id_, (channel, schema) in found.items()}

    def messages(self, topic: str) -> Messages:
        for _, channel, message in self._open().iter_messages([topic]):
            yield self.channels[channel.id], message.log_time, message.data

    def _open(self) -> Any:
        self._stream.seek(0)
        return self._reader(self._stream, True, record_size_limit=self._limit)


def _is_complete(summary: Any) -> bool:
    """Return whether the summary of an MCAP file has an index, all counts and all types."""
    if summary is None or summary.statistics is None or not summary.chunk_indexes:
        return False
    counts, types = summary.statistics.channel_message_counts, {0, *summary.schemas}
    return sum(counts.values()) == summary.statistics.message_count and all(
        id_ in summary.channels and summary.channels[id_].schema_id in types for id_ in counts)

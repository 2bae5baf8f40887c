"""Reasons why a bag cannot be read, each in one line with a remedy."""

from collections.abc import Iterable
import os
from pathlib import Path
import stat
from typing import NamedTuple

import yaml

from ..model.exceptions import BaxterDynamicsError


class BagError(BaxterDynamicsError):
    """A recording cannot be read or written; the message begins with its path."""


class Metadata(NamedTuple):
    """Contents of metadata.yaml."""

    files: list[str]  # names in the folder
    is_compressed: bool  # message by message
    counts: dict[str, int]  # topic -> messages


class _Kind(NamedTuple):
    start: bytes  # of every such file
    noun: str
    storage: str = ''  # its name in rosbag2
    repair: str = ''  # command


_MCAP = _Kind(b'\x89MCAP', 'an MCAP file', 'mcap', 'mcap recover {} -o repaired.mcap')
_SQLITE = _Kind(b'SQLite format 3\0', 'an SQLite file', 'sqlite3',
                'sqlite3 {} .recover | sqlite3 repaired.db3')
_ROS1 = _Kind(b'#ROSBAG V2.0', 'a ROS 1 bag of version 2.0', repair='rosbag reindex {}')
_KINDS = {'.mcap': _MCAP, '.db3': _SQLITE, '.bag': _ROS1, '.active': _ROS1,
          '.zstd': _Kind(b'\x28\xb5\x2f\xfd', 'a zstd file')}

_METADATA = 'metadata.yaml'
_LARGEST = 1 << 24  # of metadata.yaml [bytes]
_KILLED = ' (was the recorder killed?)'
# SQLite parses these in the name of a file given as a URI, as rosbags does.
_SQLITE_SYNTAX = '?#%'


def read_metadata(folder: Path) -> Metadata:
    """
    Return the metadata of a rosbag2 folder.

    Raises
    ------
    OSError, ValueError, LookupError, TypeError, AttributeError, YAMLError
        If it is missing or malformed.

    """
    path = folder / _METADATA
    status = path.stat()
    if not stat.S_ISREG(status.st_mode) or status.st_size > _LARGEST:
        raise ValueError('not a regular file of reasonable size')
    loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
    content = yaml.load(path.read_bytes(), loader)['rosbag2_bagfile_information']
    topics = content['topics_with_message_count']
    return Metadata(
        [Path(name).name for name in content['relative_file_paths']],
        str(content.get('compression_mode') or '').lower() == 'message',
        {topic['topic_metadata']['name']: int(topic['message_count']) for topic in topics})


def refuse_special_file(path: Path) -> None:
    """Raise BagError if a path is a pipe, a device or a socket, and OSError if it is missing."""
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise BagError(f'{path}: is neither a file nor a folder')


def refuse_unfinished(path: Path) -> None:
    """Raise BagError if SQLite keeps some of a bag's messages in a file beside it."""
    files = [path] if path.is_file() else _storage_files(path) if path.is_dir() else []
    for file in files:
        log = file.with_name(file.name + '-wal')
        if file.suffix == '.db3' and log.is_file() and log.stat().st_size:
            raise BagError(f'{file}: its last messages are in {log.name}{_KILLED}: '
                           f'`sqlite3 {file} "PRAGMA wal_checkpoint(TRUNCATE)"` adds them')


def bag_error(path: Path, error: Exception) -> BagError:
    """Return an error that says why a bag cannot be read, given the exception of its reader."""
    if isinstance(error, BagError):
        return error
    try:
        if not path.exists():
            return BagError(f'{path}: no such file or folder')
        problem = _folder_problem(path) if path.is_dir() else _file_problem(path)
    except PermissionError as denied:
        problem = f'{denied.filename}: permission denied; make it readable'
    except OSError as failure:
        problem = f'{path}: cannot be read ({failure.strerror})'
    reason = ' '.join(str(error).split()).rstrip('.') or type(error).__name__
    return BagError(problem or f'{path}: cannot be read ({reason}){_advice(path, reason)}')


def _folder_problem(folder: Path) -> 'str | None':
    metadata = folder / _METADATA
    if not metadata.exists():
        return _missing_metadata(folder)
    try:
        files = [folder / name for name in read_metadata(folder).files]
    except (yaml.YAMLError, ValueError, LookupError, TypeError, AttributeError):
        return (f'{metadata}: is not the metadata of a bag: `ros2 bag reindex {folder}` '
                'writes a new one')
    missing = [file.name for file in files if not file.exists()]
    if missing:
        return (f'{folder}: {_METADATA} lists files that are missing: {", ".join(missing)}; '
                f'restore them, or remove them from the list: `ros2 bag reindex {folder}`')
    return _first_problem(file for file in files if file.suffix in _KINDS)


def _missing_metadata(folder: Path) -> str:
    files = _storage_files(folder)
    if files:
        return _first_problem(files) or (
            f'{folder}: has no {_METADATA}{_KILLED}: `ros2 bag reindex -s '
            f'{_KINDS[files[0].suffix].storage} {folder}` writes it')
    bags = sorted(path.parent.name for path in folder.glob(f'*/{_METADATA}'))
    inside = f'; choose one of the bags in it: {", ".join(bags)}' if bags else ''
    return f'{folder}: is not a bag: it has no {_METADATA}{inside}'


def _first_problem(files: Iterable[Path]) -> 'str | None':
    return next(filter(None, map(_file_problem, files)), None)


def _file_problem(file: Path) -> 'str | None':
    with file.open('rb') as stream:
        start = stream.read(16)
        stream.seek(-min(file.stat().st_size, 16), os.SEEK_END)
        end = stream.read()
    kind = _KINDS.get(file.suffix)
    if not start:
        return f'{file}: is empty'
    if kind is None:
        if (file.parent / _METADATA).exists():
            return f'{file}: is part of a bag: name the folder {file.parent}'
        return (f'{file}: is not a bag: expected a rosbag2 folder, or a file ending in '
                '.mcap, .mcap.zstd, .db3, .bag, .npz or .csv')
    if not start.startswith(kind.start):
        return f'{file}: is not {kind.noun}, despite its name'
    if kind is _MCAP and not end.endswith(start[:8]):
        return f'{file}: is truncated{_KILLED}: `{kind.repair.format(file)}`'
    return None


def _storage_files(folder: Path) -> list[Path]:
    return sorted(file for file in folder.iterdir() if file.suffix in ('.mcap', '.db3'))


def _advice(path: Path, reason: str) -> str:
    """Return the remedy for files that look right from outside."""
    files = _storage_files(path) if path.is_dir() else [path]
    kinds = {_KINDS[file.suffix] for file in files if file.suffix in _KINDS}
    file = files[0] if len(files) == 1 else 'FILE'
    if kinds == {_SQLITE} and any(mark in str(path) for mark in _SQLITE_SYNTAX):
        return f': move it to a path without any of {" ".join(_SQLITE_SYNTAX)}'
    if kinds == {_ROS1} and 'not indexed' in reason:
        return f'{_KILLED}: `{_ROS1.repair.format(file)}`'
    repair = kinds.pop().repair if kinds else ''
    return f'; if it is damaged: `{repair.format(file)}`' if repair else ''

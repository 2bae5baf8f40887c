"""Why a bag cannot be read, in one line that says what to do."""

import os
from pathlib import Path
from typing import NamedTuple

import yaml

from .storage import read_metadata
from ..model.exceptions import BaxterDynamicsError


class BagError(BaxterDynamicsError):
    """A recording cannot be read or written; the message begins with its path."""


class _Kind(NamedTuple):
    start: bytes  # of every such file
    noun: str
    storage: str  # its name in rosbag2
    repair: str


_MCAP = _Kind(b'\x89MCAP', 'an MCAP file', 'mcap', 'mcap recover {} -o repaired.mcap')
_SQLITE = _Kind(b'SQLite format 3\0', 'an SQLite file', 'sqlite3',
                'sqlite3 {} .recover | sqlite3 repaired.db3')
_ROS1 = _Kind(b'#ROSBAG V2.0', 'a ROS 1 bag of version 2.0', '', 'rosbag reindex {}')
_ZSTD = _Kind(b'\x28\xb5\x2f\xfd', 'a zstd file', '', '')
_KINDS = {'.mcap': _MCAP, '.db3': _SQLITE, '.bag': _ROS1, '.active': _ROS1, '.zstd': _ZSTD}

_METADATA = 'metadata.yaml'
_KILLED = ' (was the recorder killed?)'
# What SQLite takes for syntax in the name of a file that is given as a URI, as rosbags does.
_SQLITE_SYNTAX = '?#%'


def refuse_unfinished(path: Path) -> None:
    """Raise BagError if SQLite keeps some of a bag's messages in a file beside it."""
    files = [path] if path.is_file() else _storage_files(path) if path.is_dir() else []
    for file in files:
        log = file.with_name(file.name + '-wal')
        if file.suffix == '.db3' and log.is_file() and log.stat().st_size:
            raise BagError(f'{file}: its last messages are in {log.name}{_KILLED}: '
                           f'`sqlite3 {file} "PRAGMA wal_checkpoint(TRUNCATE)"` adds them')


def bag_error(path: Path, error: Exception) -> BagError:
    """
    Return what is wrong with a bag as an error.

    Parameters
    ----------
    path : Path
        The bag.
    error : Exception
        What its reader met: it leads to a reason, or is quoted.

    """
    try:
        if not path.exists():
            return BagError(f'{path}: there is no such file or folder')
        problem = _folder_problem(path) if path.is_dir() else _file_problem(path)
    except PermissionError as denied:
        problem = f'{denied.filename}: permission denied; make it readable'
    except OSError as failure:
        problem = f'{path}: cannot be read ({failure.strerror})'
    return BagError(problem or f'{path}: cannot be read{_quote(error)}{_advice(path, error)}')


def _folder_problem(folder: Path) -> 'str | None':
    metadata = folder / _METADATA
    if not metadata.exists():
        files = _storage_files(folder)
        if files:
            problem = next(filter(None, map(_file_problem, files)), None)
            if problem:
                return problem
            storage = _KINDS[files[0].suffix].storage
            return (f'{folder}: has no {_METADATA}{_KILLED}: '
                    f'`ros2 bag reindex -s {storage} {folder}` makes it')
        bags = sorted(path.parent.name for path in folder.glob(f'*/{_METADATA}'))
        inside = f'; give one of the bags in it: {", ".join(bags)}' if bags else ''
        return f'{folder}: is not a bag, for it has no {_METADATA}{inside}'
    try:
        files = [folder / name for name in read_metadata(folder).files]
    except (yaml.YAMLError, ValueError, LookupError, TypeError, AttributeError):
        return (f'{metadata}: is not the metadata of a bag: `ros2 bag reindex {folder}` '
                'makes it anew')
    missing = [file.name for file in files if not file.exists()]
    if missing:
        return (f'{folder}: {_METADATA} names files that are missing: {", ".join(missing)}; bring '
                f'them back, or go without: `ros2 bag reindex {folder}`')
    problems = (_file_problem(file) for file in files if file.suffix in _KINDS)
    return next(filter(None, problems), None)


def _file_problem(file: Path) -> 'str | None':
    with file.open('rb') as stream:
        start = stream.read(16)
        stream.seek(-min(file.stat().st_size, 16), os.SEEK_END)
        end = stream.read()
    if not start:
        return f'{file}: is empty'
    kind = _KINDS.get(file.suffix)
    if kind is None:
        if (file.parent / _METADATA).exists():
            return f'{file}: is a part of a bag: give its folder, {file.parent}'
        return (f'{file}: is not a bag: give a folder of rosbag2, or a file that ends with '
                '.mcap, .mcap.zstd, .db3, .bag, .npz or .csv')
    if not start.startswith(kind.start):
        return f'{file}: is not {kind.noun}, whatever its name says'
    if kind is _MCAP and not end.endswith(start[:8]):
        return f'{file}: is cut short{_KILLED}: `{kind.repair.format(file)}`'
    return None


def _storage_files(folder: Path) -> list[Path]:
    return sorted(file for file in folder.iterdir() if file.suffix in ('.mcap', '.db3'))


def _quote(error: Exception) -> str:
    text = ' '.join(str(error).split()).rstrip('.')
    return f' ({text or type(error).__name__})'


def _advice(path: Path, error: Exception) -> str:
    """Return what to try, where the files look right from outside."""
    files = _storage_files(path) if path.is_dir() else [path]
    kinds = {_KINDS[file.suffix] for file in files if file.suffix in _KINDS}
    if not kinds:
        return ''
    file = files[0] if len(files) == 1 else 'FILE'
    if kinds == {_SQLITE} and any(mark in str(path) for mark in _SQLITE_SYNTAX):
        return f': move it to a path without any of {" ".join(_SQLITE_SYNTAX)}'
    if 'not indexed' in str(error):
        return f'{_KILLED}: `{_ROS1.repair.format(file)}`'
    repair = kinds.pop().repair
    return f'; if it is damaged: `{repair.format(file)}`' if repair else ''

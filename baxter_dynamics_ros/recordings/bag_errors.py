"""Reasons why a bag cannot be read, each in one line with a remedy."""

import os
from pathlib import Path
from typing import NamedTuple

import yaml

from .recording import BagError


class _Kind(NamedTuple):
    start: bytes  # of every such file
    noun: str
    storage: str = ''  # its name in rosbag2
    repair: str = ''  # command


_MCAP = _Kind(b'\x89MCAP', 'an MCAP file', 'mcap', 'mcap recover {} -o repaired.mcap')
_ROS1 = _Kind(b'#ROSBAG V2.0', 'a ROS 1 bag of version 2.0', repair='rosbag reindex {}')
_KINDS = {'.mcap': _MCAP, '.bag': _ROS1, '.active': _ROS1,
          '.db3': _Kind(b'SQLite format 3\0', 'an SQLite file', 'sqlite3',
                        'sqlite3 {} .recover | sqlite3 repaired.db3'),
          '.zstd': _Kind(b'\x28\xb5\x2f\xfd', 'a zstd file')}

_METADATA = 'metadata.yaml'
_KILLED = ' (was the recorder killed?)'


def read_metadata(folder: Path) -> tuple[list[str], bool]:
    """Return the files of a rosbag2 folder, and whether each message is compressed."""
    loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
    text = (folder / _METADATA).read_bytes()
    try:
        content = yaml.load(text, loader)['rosbag2_bagfile_information']
        return ([Path(name).name for name in content['relative_file_paths']],
                str(content.get('compression_mode') or '').lower() == 'message')
    except (yaml.YAMLError, ValueError, LookupError, TypeError, AttributeError):
        raise BagError(f'{folder / _METADATA}: is not the metadata of a bag: `ros2 bag reindex '
                       f'{folder}` writes a new one') from None


def refuse_unfinished(file: Path) -> None:
    """Raise BagError if SQLite keeps some of a file's messages in another one beside it."""
    log = file.with_name(file.name + '-wal')
    if file.suffix == '.db3' and log.is_file() and log.stat().st_size:
        raise BagError(f'{file}: its last messages are in {log.name}{_KILLED}: '
                       f'`sqlite3 {file} "PRAGMA wal_checkpoint(TRUNCATE)"` adds them')


def bag_error(path: Path, error: Exception) -> BagError:
    """Return an error that says why a bag cannot be read, given the exception of its reader."""
    if isinstance(error, BagError):
        return error
    files = []
    try:
        files = _storage_files(path) if path.is_dir() else [path]
        problem = _folder_problem(path, files) if path.is_dir() else _file_problem(path)
    except (FileNotFoundError, NotADirectoryError):
        problem = f'{path}: no such file or folder'
    except PermissionError as denied:
        problem = f'{denied.filename}: permission denied; make it readable'
    except OSError as failure:
        problem = f'{path}: cannot be read ({failure.strerror})'
    if problem:
        return BagError(problem)
    reason = ' '.join(str(error).split()).rstrip('.') or type(error).__name__
    repair = _KINDS[files[0].suffix].repair
    name = files[0] if len(files) == 1 else 'FILE'
    advice = f'; if it is damaged: `{repair.format(name)}`' if repair else ''
    return BagError(f'{path}: cannot be read ({reason}){advice}')


def _folder_problem(folder: Path, files: list[Path]) -> 'str | None':
    problem = next(filter(None, map(_file_problem, files)), None)
    if (folder / _METADATA).exists():
        missing = [name for name in read_metadata(folder)[0] if not (folder / name).exists()]
        return problem if not missing else (
            f'{folder}: {_METADATA} lists files that are missing: {", ".join(missing)}; restore '
            f'them, or remove them from the list: `ros2 bag reindex {folder}`')
    if files:
        return problem or (f'{folder}: has no {_METADATA}{_KILLED}: `ros2 bag reindex -s '
                           f'{_KINDS[files[0].suffix].storage} {folder}` writes it')
    bags = ', '.join(sorted(path.parent.name for path in folder.glob(f'*/{_METADATA}')))
    return f'{folder}: is not a bag: it has no {_METADATA}' + (
        f'; choose one of the bags in it: {bags}' if bags else '')


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
    return sorted(file for file in folder.iterdir() if file.suffix in _KINDS)

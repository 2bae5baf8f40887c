"""Recordings of whatever kind: bags, and arrays in .npz and .csv files, several in one."""

from collections.abc import Iterable, Sequence
import os
from pathlib import Path
import stat
from typing import TypeAlias

from .array_files import ArrayFile, ArrayRecording, read_csv, read_npz
from .bags import BagRecording
from .diagnosis import bag_error, BagError

AnyRecording: TypeAlias = BagRecording | ArrayRecording
Recordings: TypeAlias = Sequence[AnyRecording]
_READERS = {'.npz': read_npz, '.csv': read_csv}


def open_recordings(paths: Iterable[str | Path], topic: str | None = None,
                    arm: str | None = None) -> list[AnyRecording]:
    """
    Return the recordings in some files, each to be opened by ``with`` when its turn comes.

    Parameters
    ----------
    paths : iterable of Path
        Bags, one recording each, and .npz and .csv files; see :mod:`.array_files`.
    topic, arm : str, optional
        See :class:`~.bags.BagRecording`; arrays have no topics. Where the joint names of arrays
        do not include the side, it is arm, or else right.

    Raises
    ------
    BagError
        If a path is missing or neither file nor folder, or a file of arrays is malformed; other
        faults show when a recording is opened.

    """
    recordings: list[AnyRecording] = []
    for path in map(Path, paths):
        _check(path)
        if path.suffix in _READERS:
            file: ArrayFile = _READERS[path.suffix](path)
            recordings += [ArrayRecording(file, i, arm) for i in range(len(file.recordings))]
        else:
            recordings.append(BagRecording(path, topic, arm))
    return recordings


def _check(path: Path) -> None:
    """Raise BagError unless the path is a regular file or a folder."""
    try:
        mode = os.stat(path).st_mode
    except OSError as error:
        raise bag_error(path, error) from None
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise BagError(f'{path}: is neither a file nor a folder')

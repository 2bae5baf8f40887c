"""Recordings of any kind: bags, and recordings in .npz and .csv files."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TypeAlias

from .array_files import ArrayRecording, read_arrays
from .bags import BagRecording
from .recording import BagError

AnyRecording: TypeAlias = BagRecording | ArrayRecording
Recordings: TypeAlias = Sequence[AnyRecording]


def open_recordings(paths: Iterable[str | Path], topic: str | None = None,
                    arm: str | None = None) -> list[AnyRecording]:
    """
    Return the recordings in some files, each to be opened by ``with`` before it is read.

    Parameters
    ----------
    paths : iterable of Path
        Bags, one recording each, and .npz and .csv files; see :mod:`.array_files`.
    topic, arm : str, optional
        See :class:`~.bags.BagRecording`. Arrays have no topics; if their joint names do not
        include the side, it is arm, or else right.

    Raises
    ------
    BagError
        If a path is missing or neither file nor folder, or a file of arrays is malformed; other
        errors are raised when a recording is opened.

    """
    recordings: list[AnyRecording] = []
    for path in map(Path, paths):
        if not path.is_file() and not path.is_dir():
            raise BagError(f'{path}: is neither a file nor a folder' if path.exists()
                           else f'{path}: no such file or folder')
        recordings += (read_arrays(path, arm) if path.suffix in ('.npz', '.csv')
                       else [BagRecording(path, topic, arm)])
    return recordings

"""Recordings of any kind: bags, and recordings in .npz and .csv files."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TypeAlias

from .array_files import ArrayRecording, read_csv, read_npz
from .bags import BagRecording
from .diagnosis import bag_error, refuse_special_file

AnyRecording: TypeAlias = BagRecording | ArrayRecording
Recordings: TypeAlias = Sequence[AnyRecording]
_READERS = {'.npz': read_npz, '.csv': read_csv}


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
        try:
            refuse_special_file(path)
        except OSError as error:
            raise bag_error(path, error) from None
        if path.suffix in _READERS:
            file = _READERS[path.suffix](path)
            recordings += [ArrayRecording(file, i, arm) for i in range(len(file.recordings))]
        else:
            recordings.append(BagRecording(path, topic, arm))
    return recordings

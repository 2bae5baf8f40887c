"""Recordings of whatever kind: in bags, or as arrays in .npz files, several in one."""

from collections.abc import Iterable, Iterator
from functools import cached_property
import os
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from .bags import BagRecording, JointState
from .choice import choose_arm, USUAL_TOPIC
from .diagnosis import bag_error, BagError
from .writer import BagWriter
from ..model.arrays import Array
from ..model.joints import JOINTS

_START = 10**18  # stamp of the first joint state of what has no stamps [ns]
_ARRAYS = ('position', 'velocity', 'effort')
_KEYS = ('joint_names', 'period', 'recording', 'recording_names', *_ARRAYS)


def open_recordings(paths: Iterable[str | Path], topic: str | None = None,
                    arm: str | None = None) -> 'list[BagRecording | ArrayRecording]':
    """
    Return the recordings in some files, each to be opened by ``with``, when its turn comes.

    Parameters
    ----------
    paths : iterable of Path
        Bags, one recording each, and .npz files, whose layout is :class:`ArrayFile`'s.
    topic, arm : str, optional
        See :class:`~.bags.BagRecording`; an .npz file has no topics. Where its joint names do not
        tell the side, it is arm, or else right.

    Returns
    -------
    list of BagRecording and ArrayRecording

    Raises
    ------
    BagError
        If a path is missing, or an .npz file is not as it should be; what else may be wrong shows
        when a recording is opened.

    """
    recordings: list[BagRecording | ArrayRecording] = []
    for path in map(Path, paths):
        if not os.path.exists(path):  # or cannot be seen
            raise bag_error(path, FileNotFoundError())
        if path.suffix == '.npz':
            file = ArrayFile(path)
            recordings += [ArrayRecording(file, i, arm) for i in range(len(file.recordings))]
        else:
            recordings.append(BagRecording(path, topic, arm))
    return recordings


class ArrayFile:
    """
    An .npz file with recordings, as rows of one period, one recording after the other.

    It holds joint_names (j), period [s], recording (row -> index of its recording),
    recording_names, and position [rad], velocity [rad/s] and effort [N m], each (rows, j).

    Parameters
    ----------
    path : Path
        The file.

    Attributes
    ----------
    joints : list of str
        As the file names them.
    period : float
        Between two rows [s].
    recordings : list of str
        Names.
    rows : ndarray (rows,) of int
        Index of each row's recording.

    Raises
    ------
    BagError
        If it is not such a file.

    """

    def __init__(self, path: Path) -> None:
        self.path = path
        contents = self._load(_KEYS[:-len(_ARRAYS)])
        self.joints = [str(name) for name in np.ravel(contents['joint_names'])]
        self.recordings = [str(name) for name in np.ravel(contents['recording_names'])]
        self.rows = np.ravel(contents['recording'])
        period = contents['period']
        if period.shape or period.dtype.kind not in 'fiu' or not 0 < period < np.inf:
            raise BagError(f'{path}: period must be a positive number of seconds, is {period}')
        self.period = float(period)

    @cached_property
    def arrays(self) -> tuple[Array, ...]:
        """Return position, velocity and effort, each (rows, j), read from the file once."""
        contents = self._load(_ARRAYS)
        shape = (len(self.rows), len(self.joints))
        for key, array in contents.items():
            if array.shape != shape or array.dtype.kind not in 'fiu':
                raise BagError(f'{self.path}: {key} must have {shape[0]} rows (as recording) of '
                               f'{shape[1]} numbers (as joint_names), is {array.dtype} '
                               f'{array.shape}')
        return tuple(np.ascontiguousarray(contents[key], float) for key in _ARRAYS)

    def _load(self, keys: tuple[str, ...]) -> dict[str, Any]:
        try:
            with np.load(self.path, allow_pickle=False) as file:
                missing = [key for key in _KEYS if key not in file]
                if missing:
                    raise BagError(f'{self.path}: lacks {", ".join(missing)}; a file of '
                                   f'recordings holds {", ".join(_KEYS)}')
                return {key: file[key] for key in keys}
        except PermissionError as error:
            raise bag_error(self.path, error) from None
        except (OSError, EOFError, ValueError, TypeError, AttributeError, BadZipFile) as error:
            raise BagError(f'{self.path}: cannot be read as .npz; is it complete? '
                           f'({error})') from None


class ArrayRecording:
    """
    One recording of an .npz file; behaves as :class:`~.bags.BagRecording` does.

    Its stamps are made from the period.

    Parameters
    ----------
    file : ArrayFile
        Where it is.
    index : int
        Its number there.
    arm : str, optional
        'right' or 'left'.

    """

    def __init__(self, file: ArrayFile, index: int, arm: str | None = None) -> None:
        self.path = file.path
        self.name = file.recordings[index]
        self.topic = USUAL_TOPIC
        self.arm: str = arm  # type: ignore[assignment]  # None until it is open
        self.count = int(np.count_nonzero(file.rows == index))
        self._file = file
        self._index = index

    def __enter__(self) -> 'ArrayRecording':
        """Find the arm and load the file."""
        joints = self._file.joints
        if not set(joints).isdisjoint(JOINTS):
            joints = [f'{self.arm or "right"}_{joint}' for joint in joints]
        self.arm = choose_arm(f'{self.path}: {self.name}', set(joints), self.arm)
        chosen = self._file.rows == self._index
        self._names = joints
        self._arrays = [array[chosen] for array in self._file.arrays]
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Forget the arrays."""
        del self._arrays

    def __iter__(self) -> Iterator[JointState]:
        """Yield each :class:`~.bags.JointState`."""
        for i, (position, velocity, effort) in enumerate(zip(*self._arrays)):
            stamp_ns = _START + round(i * self._file.period * 1e9)
            yield JointState(stamp_ns, self._names, position, velocity, effort, stamp_ns)

    def copied_to(self, writer: BagWriter) -> Iterator[JointState]:
        """Yield the same, and on the way write it."""
        for state in self:
            writer.joint_state(self.topic, *state)
            yield state

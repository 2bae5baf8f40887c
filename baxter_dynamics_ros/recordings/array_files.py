"""
Recordings as arrays: .npz files, and .csv files as most laboratories publish them.

An .npz file holds, for n rows and j joints,

================  =========  ==========================================================
joint_names       (j,)       of one or both arms, such as right_s0, or s0 of either arm
position          (n, j)     [rad]
velocity          (n, j)     [rad/s]
effort            (n, j)     [N m]
period            ()         time between two rows [s], or instead of it
stamp             (n,)       the robot's stamps [s]
recording         (n,)       optional: index of the row's recording in recording_names
recording_names   (r,)       optional, with recording
================  =========  ==========================================================

Instead of joint_names, the key may be names. A .csv file is one recording. Its header has
``time`` (or ``stamp``) and, for each joint, ``s0_position``, ``s0_velocity`` and ``s0_effort``,
with or without ``right_`` or ``left_`` before them; other columns are ignored.
"""

from collections.abc import Iterator
import csv
from functools import cached_property
from pathlib import Path
from typing import Any, IO, NamedTuple, NoReturn
from zipfile import BadZipFile, ZipFile

import numpy as np

from .bags import JointState
from .choice import choose_arm, USUAL_TOPIC
from .diagnosis import bag_error, BagError
from ..model.arrays import Array
from ..model.joints import JOINTS, SIDES

_START = 10**18  # stamp of the first joint state where only the period is known [ns]
_ARRAYS = ('position', 'velocity', 'effort')
_LARGEST = 4 << 30  # size of an array [bytes]: eight hours of both arms at 1000 Hz
_DENSEST = 200  # compression of a large array that is a recording
_LONGEST = 1.0  # period [s]


class ArrayFile(NamedTuple):
    """Recordings as rows of arrays, one recording after the other."""

    path: Path
    joints: list[str]  # as the file names them
    stamps_ns: Any  # (n,) of int [ns]
    recordings: list[str]  # names
    rows: Any  # (n,) index of each row's recording
    arrays: tuple[Array, Array, Array]  # position, velocity, effort, (n, j)


def read_npz(path: Path) -> ArrayFile:
    """
    Read an .npz file; see above.

    Raises
    ------
    BagError
        If it is not such a file.

    """
    try:
        _check_sizes(path)
        with np.load(path, allow_pickle=False) as file:
            contents = {key: file[key] for key in file.files}
    except PermissionError as error:
        raise bag_error(path, error) from None
    except (OSError, EOFError, ValueError, TypeError, AttributeError, SyntaxError, MemoryError,
            BadZipFile) as error:
        reason = ' '.join(str(error).split())
        raise BagError(
            f'{path}: cannot be read as .npz; is it complete? ({reason:.200})') from None
    contents.setdefault('joint_names', contents.get('names'))
    missing = [key for key in ('joint_names', *_ARRAYS) if contents.get(key) is None]
    if 'period' not in contents and 'stamp' not in contents:
        missing.append('period or stamp')
    if missing:
        raise BagError(f'{path}: lacks {", ".join(missing)}; it has {", ".join(contents)}')
    return _checked(path, contents)


def _check_sizes(path: Path) -> None:
    """Refuse arrays that are too large, by the sizes in the archive and in their headers."""
    with ZipFile(path) as archive:
        for entry in archive.infolist():
            size, packed = entry.file_size, entry.compress_size
            if size > _LARGEST or size > _LARGEST // 64 and size > _DENSEST * packed:
                raise BagError(f'{path}: {entry.filename} would unpack from {packed} to {size} '
                               'bytes; a recording has no such array')
            with archive.open(entry) as file:
                declared = _declared_size(file)
            if declared > size:
                raise BagError(f'{path}: {entry.filename} declares {declared:.3g} bytes and has '
                               f'{size}')


def _declared_size(file: IO[bytes]) -> float:
    version = np.lib.format.read_magic(file)
    shape, _, dtype = (np.lib.format.read_array_header_1_0 if version == (1, 0)
                       else np.lib.format.read_array_header_2_0)(file)
    return float(np.prod(shape, dtype=float)) * dtype.itemsize


def _checked(path: Path, contents: dict[str, Any]) -> ArrayFile:
    joints = [str(name) for name in np.ravel(contents['joint_names'])]
    n = len(np.atleast_1d(contents['position']))
    for key in _ARRAYS:
        array = contents[key]
        if array.shape != (n, len(joints)) or array.dtype.kind not in 'fiu':
            raise BagError(f'{path}: {key} must have {n} rows of {len(joints)} numbers (as '
                           f'joint_names), is {array.dtype} {array.shape}')
    rows = contents.get('recording', np.zeros(n, int))
    names = [str(name) for name in np.ravel(contents.get('recording_names', path.stem))]
    if rows.shape != (n,) or rows.dtype.kind not in 'iu':
        raise BagError(f'{path}: recording must have {n} whole numbers, is {rows.dtype} '
                       f'{rows.shape}')
    nameless = (rows < 0) | (rows >= len(names))
    if nameless.any():
        raise BagError(f'{path}: {nameless.sum()} of {n} rows belong to recording '
                       f'{rows[nameless][0]}, but recording_names has {len(names)} names')
    position, velocity, effort = (np.ascontiguousarray(contents[key], float) for key in _ARRAYS)
    return ArrayFile(path, joints, _stamps_ns(path, contents, rows), names, rows,
                     (position, velocity, effort))


def _stamps_ns(path: Path, contents: dict[str, Any], rows: Any) -> Any:
    """Return the stamps of all rows, by each recording's period if there are none."""
    if 'stamp' in contents:
        stamps = contents['stamp']
        if stamps.shape != rows.shape or stamps.dtype.kind not in 'fiu' or not np.all(
                (stamps >= 0.0) & (stamps < 2.0**31)):
            raise BagError(f'{path}: stamp must have {len(rows)} numbers of seconds from 0 to '
                           f'2^31, is {stamps.dtype} {stamps.shape}')
        whole = np.floor(stamps)
        return whole.astype(np.int64) * 10**9 + np.rint((stamps - whole) * 1e9).astype(np.int64)
    period = contents['period']
    if period.shape or period.dtype.kind not in 'fiu' or not 0 < period <= _LONGEST:
        raise BagError(f'{path}: period must be a number of seconds up to {_LONGEST:g}, is '
                       f'{period}')
    result = np.zeros(len(rows), np.int64)
    for index in np.unique(rows):
        chosen = rows == index
        result[chosen] = _START + np.rint(
            np.arange(chosen.sum()) * float(period) * 1e9).astype(np.int64)
    return result


def read_csv(path: Path) -> ArrayFile:
    """
    Read a .csv file; see above.

    Raises
    ------
    BagError
        If it is not such a file.

    """
    def refuse(reason: object) -> NoReturn:
        raise BagError(f'{path}: {reason}')

    try:
        with path.open(newline='', encoding='utf-8-sig') as file:
            header = [name.strip() for name in next(csv.reader(file), [])]
            columns = _columns(header) or refuse(
                'expected columns time, s0_position, s0_velocity, s0_effort and so on for the '
                f'joints of one arm, got {", ".join(header):.200}')
            data = np.loadtxt(file, delimiter=',', ndmin=2, usecols=range(len(header)))
    except OSError as error:
        raise bag_error(path, error) from None
    except (ValueError, csv.Error) as error:
        refuse(f'cannot be read as CSV ({" ".join(str(error).split()):.200})')
    prefix, time = columns
    contents = {key: data[:, [header.index(f'{prefix}{joint}_{key}') for joint in JOINTS]]
                for key in _ARRAYS}
    return _checked(path, {**contents, 'stamp': data[:, time],
                           'joint_names': [f'{prefix}{joint}' for joint in JOINTS]})


def _columns(header: list[str]) -> 'tuple[str, int] | None':
    """Return the prefix of the joints' columns and the column of time."""
    time = next((header.index(name) for name in ('time', 'stamp') if name in header), None)
    for prefix in ('', *(f'{side}_' for side in SIDES)):
        if time is not None and all(f'{prefix}{joint}_{key}' in header
                                    for joint in JOINTS for key in _ARRAYS):
            return prefix, time
    return None


class ArrayRecording:
    """
    One recording of an array file; behaves like :class:`~.bags.BagRecording`.

    Parameters
    ----------
    file : ArrayFile
        Its file.
    index : int
        Its number in the file.
    arm : str, optional
        'right' or 'left'.

    """

    def __init__(self, file: ArrayFile, index: int, arm: str | None = None) -> None:
        self.path = file.path
        self.name = file.recordings[index]
        self.topic = USUAL_TOPIC
        self.arm: str = arm  # type: ignore[assignment]  # None until it is open
        self.count = int(np.count_nonzero(file.rows == index))
        self.remarks: list[str] = []
        self._file = file
        self._index = index

    @cached_property
    def _names(self) -> list[str]:
        joints = self._file.joints
        if not set(joints).isdisjoint(JOINTS):
            return [f'{self.arm or "right"}_{joint}' for joint in joints]
        return joints

    def __enter__(self) -> 'ArrayRecording':
        """Find the arm."""
        self.arm = choose_arm(f'{self.path}: {self.name}', set(self._names), self.arm)
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Do nothing: the arrays stay."""

    def __iter__(self) -> Iterator[JointState]:
        """Yield each :class:`~.bags.JointState`."""
        for i in np.flatnonzero(self._file.rows == self._index).tolist():
            stamp_ns = int(self._file.stamps_ns[i])
            position, velocity, effort = (array[i] for array in self._file.arrays)
            yield JointState(stamp_ns, self._names, position, velocity, effort, stamp_ns)

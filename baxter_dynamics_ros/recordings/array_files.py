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
from pathlib import Path
from typing import Any, NamedTuple
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
_DENSEST = 200  # largest compression ratio of a large array
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
    """Read an .npz file; raise BagError if it is malformed."""
    try:
        _check_sizes(path)
        with np.load(path, allow_pickle=False) as file:
            contents = {key: file[key] for key in file.files}
    except PermissionError as error:
        raise bag_error(path, error) from None
    except (OSError, EOFError, ValueError, TypeError, AttributeError, SyntaxError, MemoryError,
            BadZipFile) as error:
        raise _malformed(path, '.npz; is it complete?', error) from None
    contents.setdefault('joint_names', contents.get('names'))
    missing = [key for key in ('joint_names', *_ARRAYS) if contents.get(key) is None]
    if 'period' not in contents and 'stamp' not in contents:
        missing.append('period or stamp')
    if missing:
        raise BagError(f'{path}: lacks {", ".join(missing)}; it has {", ".join(contents)}')
    return _checked(path, contents)


def read_csv(path: Path) -> ArrayFile:
    """Read a .csv file; raise BagError if it is malformed."""
    try:
        with path.open(newline='', encoding='utf-8-sig') as file:
            header = [name.strip() for name in next(csv.reader(file), [])]
            wanted = _columns(header)
            if not wanted:
                raise BagError(
                    f'{path}: expected columns time, s0_position, s0_velocity, s0_effort and so '
                    f'on for the joints of one arm, got {", ".join(header):.200}')
            data = np.loadtxt(file, delimiter=',', ndmin=2, usecols=range(len(header)))
    except OSError as error:
        raise bag_error(path, error) from None
    except (ValueError, csv.Error) as error:
        raise _malformed(path, 'CSV', error) from None
    prefix, time = wanted
    contents = {key: data[:, [header.index(f'{prefix}{joint}_{key}') for joint in JOINTS]]
                for key in _ARRAYS}
    return _checked(path, {**contents, 'stamp': data[:, header.index(time)],
                           'joint_names': [f'{prefix}{joint}' for joint in JOINTS]})


def _columns(header: list[str]) -> 'tuple[str, str] | None':
    """Return the prefix of the joints' columns and the column of time."""
    for prefix in ('', *(f'{side}_' for side in SIDES)):
        for time in ('time', 'stamp'):
            if {time, *(f'{prefix}{joint}_{key}' for joint in JOINTS for key in _ARRAYS)} <= {
                    *header}:
                return prefix, time
    return None


def _malformed(path: Path, kind: str, error: Exception) -> BagError:
    return BagError(f'{path}: cannot be read as {kind} ({" ".join(str(error).split()):.200})')


def _check_sizes(path: Path) -> None:
    """Refuse arrays that are too large, by the sizes in the archive and in their headers."""
    with ZipFile(path) as archive:
        for entry in archive.infolist():
            size, packed = entry.file_size, entry.compress_size
            if size > _LARGEST or size > _LARGEST // 64 and size > _DENSEST * packed:
                raise BagError(f'{path}: {entry.filename} would unpack from {packed} to {size} '
                               'bytes, which no recording does')
            with archive.open(entry) as file:
                version = np.lib.format.read_magic(file)
                shape, _, dtype = (np.lib.format.read_array_header_1_0 if version == (1, 0)
                                   else np.lib.format.read_array_header_2_0)(file)
            declared = float(np.prod(shape, dtype=float)) * dtype.itemsize
            if declared > size:
                raise BagError(f'{path}: {entry.filename} declares {declared:.3g} bytes but has '
                               f'{size}')


def _checked(path: Path, contents: dict[str, Any]) -> ArrayFile:
    joints = [str(name) for name in np.ravel(contents['joint_names'])]
    n = len(np.atleast_1d(contents['position']))
    rows = contents.setdefault('recording', np.zeros(n, int))
    names = [str(name) for name in np.ravel(contents.get('recording_names', path.stem))]
    table = f'have {n} rows of {len(joints)} numbers (as joint_names)'
    rules = {key: ((n, len(joints)), 'fiu', table) for key in _ARRAYS} | {
        'recording': ((n,), 'iu', f'have {n} integers'),
        'period': ((), 'fiu', f'be a number of seconds up to {_LONGEST:g}'),
        'stamp': ((n,), 'fiu', f'have {n} numbers of seconds from 0 to 2^31')}
    for key, (shape, kinds, wanted) in rules.items():
        array = contents.get(key)
        if array is not None and (
                array.shape != shape or array.dtype.kind not in kinds
                or key == 'period' and not 0.0 < array <= _LONGEST
                or key == 'stamp' and not ((array >= 0.0) & (array < 2.0**31)).all()):
            found = f'{array}' if not shape and array.size < 9 else f'{array.dtype} {array.shape}'
            raise BagError(f'{path}: {key} must {wanted}, is {found}')
    nameless = (rows < 0) | (rows >= len(names))
    if nameless.any():
        raise BagError(f'{path}: {nameless.sum()} of {n} rows belong to recording '
                       f'{rows[nameless][0]}, but recording_names has {len(names)} names')
    position, velocity, effort = (np.ascontiguousarray(contents[key], float) for key in _ARRAYS)
    return ArrayFile(path, joints, _stamps_ns(contents), names, rows, (position, velocity, effort))


def _stamps_ns(contents: dict[str, Any]) -> Any:
    """Return the stamps of all rows, or multiples of the period within each recording."""
    rows = contents['recording']
    if 'stamp' in contents:
        whole = np.floor(contents['stamp'])
        fraction = np.rint((contents['stamp'] - whole) * 1e9)
        return whole.astype(np.int64) * 10**9 + fraction.astype(np.int64)
    result = np.zeros(len(rows), np.int64)
    for index in np.unique(rows):
        chosen = rows == index
        result[chosen] = _START + np.rint(
            np.arange(chosen.sum()) * float(contents['period']) * 1e9).astype(np.int64)
    return result


class ArrayRecording:
    """
    One recording of an array file; behaves like :class:`~.bags.BagRecording`.

    Parameters
    ----------
    file : ArrayFile
        The file.
    index : int
        Index of the recording in the file.
    arm : str, optional
        'right' or 'left'.

    """

    def __init__(self, file: ArrayFile, index: int, arm: str | None = None) -> None:
        self.path = file.path
        self.name = file.recordings[index]
        self.topic = USUAL_TOPIC
        self.arm: str = arm  # type: ignore[assignment]  # None until it is open
        self.remarks: list[str] = []
        self._file = file
        self._rows = np.flatnonzero(file.rows == index)
        self.count = len(self._rows)
        self._names = file.joints
        if not set(JOINTS).isdisjoint(file.joints):
            self._names = [f'{arm or "right"}_{joint}' for joint in file.joints]

    def __enter__(self) -> 'ArrayRecording':
        """Find the arm."""
        self.arm = choose_arm(f'{self.path}: {self.name}', set(self._names), self.arm)
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Do nothing: the arrays stay."""

    def __iter__(self) -> Iterator[JointState]:
        """Yield each :class:`~.bags.JointState`."""
        for i in self._rows.tolist():
            stamp_ns = int(self._file.stamps_ns[i])
            position, velocity, effort = (array[i] for array in self._file.arrays)
            yield JointState(stamp_ns, self._names, position, velocity, effort, stamp_ns)

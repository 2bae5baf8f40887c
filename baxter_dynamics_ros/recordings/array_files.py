"""
Recordings as arrays: .npz files, and .csv files as most laboratories publish them.

docs/calibrate.md describes both. An .npz file may hold several recordings, and joints of both arms
or without a side; a .csv file is one recording of one arm.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from .recording import BagError, choose_arm, JointState, USUAL_TOPIC
from ..model.arrays import Array
from ..model.joints import JOINTS, SIDES

_START = 10**18  # stamp of the first joint state where only the period is known [ns]
_ARRAYS = ('position', 'velocity', 'effort')
_LONGEST = 1.0  # period [s]


class ArrayRecording:
    """One recording of an array file; behaves like :class:`~.reader.BagRecording`."""

    topic = USUAL_TOPIC

    def __init__(self, path: Path, name: str, joints: list[str], stamps_ns: Any,
                 arrays: tuple[Array, ...], arm: 'str | None') -> None:
        self.path, self.name = path, name
        self.arm = choose_arm(f'{path}: {name}', set(joints), arm)
        self.count = len(stamps_ns)
        self._joints = joints  # names of j joints
        self._stamps_ns = stamps_ns  # (n,) [ns]
        self._arrays = arrays  # position [rad], velocity [rad/s] and effort [N m], (n, j) each

    def __enter__(self) -> 'ArrayRecording':
        """Return the recording."""
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Do nothing: the arrays stay."""

    def __iter__(self) -> Iterator[JointState]:
        """Yield each joint state; the stamp is also the time of recording."""
        for stamp_ns, position, velocity, effort in zip(self._stamps_ns.tolist(), *self._arrays):
            yield JointState(stamp_ns, self._joints, position, velocity, effort, stamp_ns)


def read_arrays(path: Path, arm: str | None = None) -> list[ArrayRecording]:
    """Return the recordings in an .npz or .csv file; raise BagError if it is malformed."""
    try:
        contents = _csv(path) if path.suffix == '.csv' else _npz(path)
    except (OSError, EOFError, ValueError, TypeError, AttributeError, SyntaxError, MemoryError,
            BadZipFile) as error:
        reason = getattr(error, 'strerror', None) or ' '.join(str(error).split())
        raise BagError(f'{path}: cannot be read as {path.suffix}; is it complete? '
                       f'({reason:.200})') from None
    _check(path, contents)
    joints = [str(name) for name in np.ravel(contents['joint_names'])]
    if not set(JOINTS).isdisjoint(joints):
        joints = [f'{arm or "right"}_{joint}' for joint in joints]
    names = [str(name) for name in np.ravel(contents.get('recording_names', path.stem))]
    owner = contents.get('recording', np.zeros(len(contents['position']), int))
    nameless = (owner < 0) | (owner >= len(names))
    if nameless.any():
        raise BagError(f'{path}: {nameless.sum()} of {len(owner)} rows belong to recording '
                       f'{owner[nameless][0]}, but recording_names has {len(names)} names')
    recordings = []
    for index, name in enumerate(names):
        rows = np.flatnonzero(owner == index)
        arrays = tuple(np.ascontiguousarray(contents[key][rows], float) for key in _ARRAYS)
        recordings.append(ArrayRecording(path, name, joints, _stamps_ns(contents, rows), arrays,
                                         arm))
    return recordings


def _npz(path: Path) -> dict[str, Any]:
    with np.load(path, allow_pickle=False) as file:
        contents = {key: file[key] for key in file.files}
    contents.setdefault('joint_names', contents.get('names'))
    missing = [key for key in ('joint_names', *_ARRAYS) if contents.get(key) is None]
    if 'period' not in contents and 'stamp' not in contents:
        missing.append('period or stamp')
    if missing:
        raise BagError(f'{path}: lacks {", ".join(missing)}; it has {", ".join(contents)}')
    return contents


def _csv(path: Path) -> dict[str, Any]:
    with path.open(encoding='utf-8-sig') as file:
        header = [name.strip() for name in file.readline().split(',')]
        time = next((name for name in ('time', 'stamp') if name in header), None)
        for prefix in ('', *(f'{side}_' for side in SIDES)):
            joints = [prefix + joint for joint in JOINTS]
            wanted = {f'{joint}_{key}' for joint in joints for key in _ARRAYS}
            if time and wanted <= {*header}:
                columns = dict(zip(header, np.loadtxt(
                    file, delimiter=',', ndmin=2, usecols=range(len(header))).T))
                return {'joint_names': joints, 'stamp': columns[time], **{
                    key: np.stack([columns[f'{joint}_{key}'] for joint in joints], axis=1)
                    for key in _ARRAYS}}
    raise BagError(f'{path}: expected columns time, s0_position, s0_velocity, s0_effort and so on '
                   f'for the joints of one arm, got {", ".join(header):.200}')


def _check(path: Path, contents: dict[str, Any]) -> None:
    """Raise BagError if an array has the wrong shape, type or range."""
    n, joints = len(np.atleast_1d(contents['position'])), np.size(contents['joint_names'])
    table = f'have {n} rows of {joints} numbers (as joint_names)'
    rules = {key: ((n, joints), 'fiu', table) for key in _ARRAYS} | {
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


def _stamps_ns(contents: dict[str, Any], rows: Any) -> Any:
    """Return the stamps of some rows, or multiples of the period."""
    if 'stamp' not in contents:
        period = 1e9 * float(contents['period'])
        return _START + np.rint(np.arange(len(rows)) * period).astype(np.int64)
    whole = np.floor(contents['stamp'][rows])
    fraction = np.rint((contents['stamp'][rows] - whole) * 1e9)
    return whole.astype(np.int64) * 10**9 + fraction.astype(np.int64)

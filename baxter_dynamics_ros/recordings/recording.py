"""Recordings: joint states of one arm in their order; those in .npz and .csv files."""

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..model import Array, BaxterDynamicsError, first_names, joint_names, JOINTS, SIDES

USUAL_TOPIC = '/robot/joint_states'

_START = 10**18  # stamp of the first joint state where only the period is known [ns]
_ARRAYS = ('position', 'velocity', 'effort')
_KEYS = (*_ARRAYS, 'joint_names', 'names', 'period', 'stamp', 'recording', 'recording_names')
_LONGEST = 1.0  # period [s]


class BagError(BaxterDynamicsError):
    """A recording cannot be read or written; the message begins with its path."""


class RecordedState(NamedTuple):
    """A joint state as recorded."""

    stamp_ns: int  # of the header [ns]
    names: Sequence[str]  # joints
    position: Array  # [rad]; as long as names, unless the message is malformed
    velocity: Array  # [rad/s]; as long, or empty
    effort: Array  # [N m]; as long, or empty
    received_ns: int  # time of recording [ns]


class Recording(AbstractContextManager['Recording']):
    """Joint states of one arm, in the order of recording; a context manager to read them in."""

    name: str
    arm: str
    topic: str
    count: int  # messages

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Do nothing."""

    def __iter__(self) -> Iterator[RecordedState]:
        """Yield each joint state, any number of times."""
        raise NotImplementedError


@dataclass(eq=False)
class ArrayRecording(Recording):
    """Recording in arrays."""

    name: str
    arm: str
    joints: Sequence[str]  # names of j joints
    stamps_ns: Array  # (n,) [ns]
    arrays: Sequence[Array]  # position [rad], velocity [rad/s] and effort [N m], (n, j) each
    received_ns: 'Array | None' = None  # (n,) times of recording [ns]; the stamps by default
    topic: str = USUAL_TOPIC

    def __post_init__(self) -> None:
        """Count the joint states."""
        self.count = len(self.stamps_ns)

    def __iter__(self) -> Iterator[RecordedState]:
        """Yield each joint state."""
        received = self.stamps_ns if self.received_ns is None else self.received_ns
        for stamp_ns, received_ns, position, velocity, effort in zip(
                self.stamps_ns.tolist(), received.tolist(), *self.arrays):
            yield RecordedState(stamp_ns, self.joints, position, velocity, effort, received_ns)


def choose_arm(where: str, names: set[str], arm: 'str | None', prefix: str) -> str:
    """Return the requested arm, or the only one, among recorded joints; raise BagError."""
    sides = sides_of(names, arm, prefix)
    if not sides:
        found = (f'only {first_names(sorted(names))}' if names else
                 'its joint states name no joints')
        if any(name.endswith(joint_names('right') + joint_names('left')) for name in names):
            found += '; check --arm and the parameters arm and joint_prefix'
        raise BagError(f'{where} has no joints of {f"the {arm}" if arm else "an"} arm'
                       f'{f" with the prefix {prefix}" if prefix else ""}, {found}')
    if len(sides) > 1:
        raise BagError(f"{where} has both arms' joints: choose --arm right or --arm left")
    return sides[0]


def sides_of(names: set[str], arm: 'str | None', prefix: str) -> list[str]:
    """Return the sides whose joints, with the prefix, are among the names; only arm if given."""
    return [side for side in SIDES if arm in (None, side)
            and any(prefix + joint in names for joint in joint_names(side))]


def read_arrays(path: Path, arm: str | None, prefix: str) -> list[ArrayRecording]:
    """Return the recordings in an .npz or .csv file; raise BagError if its contents are wrong."""
    contents = _csv(path, prefix) if path.suffix == '.csv' else _npz(path)
    _check(path, contents)
    joints = [str(name).removeprefix(prefix) for name in np.ravel(contents['joint_names'])]
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
        recordings.append(ArrayRecording(
            name, choose_arm(f'{path}: {name}', set(joints), arm, ''),
            [prefix + joint for joint in joints], _stamps_ns(contents, rows), arrays))
    return recordings


def _npz(path: Path) -> dict[str, Any]:
    with np.load(path, allow_pickle=False) as file:
        contents = {key: file[key] for key in file.files if key in _KEYS}
    contents.setdefault('joint_names', contents.get('names'))
    missing = [key for key in ('joint_names', *_ARRAYS) if contents.get(key) is None]
    if 'period' not in contents and 'stamp' not in contents:
        missing.append('period or stamp')
    if missing:
        raise BagError(f'{path}: lacks {", ".join(missing)}; it has {", ".join(file.files)}')
    return contents


def _csv(path: Path, prefix: str) -> dict[str, Any]:
    with path.open(encoding='utf-8-sig') as file:
        header = [name.strip().removeprefix(prefix) for name in file.readline().split(',')]
        time = next((name for name in ('time', 'stamp') if name in header), None)
        arms = [joints for joints in (JOINTS, *map(joint_names, SIDES))
                if {f'{joint}_{key}' for joint in joints for key in _ARRAYS} <= {*header}]
        if not time or not arms:
            raise BagError(f'{path}: expected columns time, s0_position, s0_velocity, s0_effort '
                           'and so on for the joints of one arm, got '
                           f'{", ".join(header):.200}')
        first = next((line for line in file if line.partition('#')[0].strip()), '')
        if not first:
            raise BagError(f'{path}: has no rows')
        joints = [*chain(*arms)]
        wanted = [time, *(f'{joint}_{key}' for joint in joints for key in _ARRAYS)]
        table = np.loadtxt(chain([first], file), delimiter=',', ndmin=2,
                           usecols=[*map(header.index, wanted)])
    arrays = table[:, 1:].reshape(len(table), len(joints), len(_ARRAYS))
    return {'joint_names': joints, 'stamp': table[:, 0],
            **dict(zip(_ARRAYS, np.moveaxis(arrays, 2, 0)))}


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
    stamps = contents['stamp'][rows]
    fraction, whole = np.modf(stamps.astype(np.result_type(stamps, float)))
    stamps_ns = whole.astype(np.int64) * 10**9 + np.rint(fraction * 1e9).astype(np.int64)
    return np.maximum(stamps_ns, 1)  # zero would mean unstamped

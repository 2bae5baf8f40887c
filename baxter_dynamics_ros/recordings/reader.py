"""Recordings of any kind: bags of ROS 1 and ROS 2, and arrays in .npz and .csv files."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias
from zipfile import BadZipFile

import numpy as np
from rosbags.serde import SerdeError
from rosbags.typesys import Stores

from .bag_files import bag_error, BagFiles, Channel, type_store
from .recording import (BagError, choose_arm, JOINT_STATE, JointState, listed, sides_of,
                        USUAL_TOPIC)
from ..model.arrays import Array
from ..model.joints import JOINTS, SIDES

_PEEK = 1000  # messages read to find the arms on a topic; more until there is one
_PADDING = (0, 4, 8)  # bytes that some writers append to a message
_START = 10**18  # stamp of the first joint state where only the period is known [ns]
_ARRAYS = ('position', 'velocity', 'effort')
_LONGEST = 1.0  # period [s]

AnyRecording: TypeAlias = 'BagRecording | ArrayRecording'
Recordings: TypeAlias = Sequence[AnyRecording]


def open_recordings(paths: Iterable[str | Path], topic: str | None = None,
                    arm: str | None = None) -> list[AnyRecording]:
    """
    Return the recordings in some files, each to be opened by ``with`` before it is read.

    A bag is one recording; .npz and .csv files, which are read at once, are described in
    docs/calibrate.md. The topic is by default the robot's usual one, or the only one with an arm's
    joints, and the arm the only one in the recording; joints without a side are of the right arm.
    Raises BagError if a path is missing or neither file nor folder, or a file of arrays is
    malformed; other errors are raised when a recording is opened.
    """
    recordings: list[AnyRecording] = []
    for path in map(Path, paths):
        try:
            path.stat()
            if not path.is_file() and not path.is_dir():
                raise BagError(f'{path}: is neither a file nor a folder')
        except (OSError, BagError) as error:
            raise bag_error(path, error) from None
        recordings += (read_arrays(path, arm) if path.suffix in ('.npz', '.csv')
                       else [BagRecording(path, topic, arm)])
    return recordings


class BagRecording:
    """
    Joint states of one arm in a bag; a context manager that keeps the bag open.

    Iterating yields each :class:`~.recording.JointState` on the topic, any number of times, and
    raises BagError at a damaged place. Memory does not grow with the bag, except for an MCAP file
    without an index and the index of a ROS 1 bag.
    """

    topic: str  # known once it is open, as are the next two
    arm: str
    count: int  # joint states on the topic

    def __init__(self, path: Path, topic: 'str | None' = None, arm: 'str | None' = None) -> None:
        self.path = path
        name = path.resolve().name
        self.name = name if path.is_dir() else Path(name.removesuffix('.zstd')).stem
        self._wanted = topic, arm

    def __enter__(self) -> 'BagRecording':
        """Open the bag and find topic and arm."""
        try:
            self._files = BagFiles(self.path)
        except Exception as error:  # a damaged file makes the libraries raise anything
            raise bag_error(self.path, error) from None
        try:
            self._choose(*self._wanted)
        except BaseException:
            self._files.close()
            raise
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Close the bag."""
        self._files.close()

    def __iter__(self) -> Iterator[JointState]:
        """Yield each joint state of the topic."""
        return self._play(self.topic)

    def _choose(self, topic: 'str | None', arm: 'str | None') -> None:
        """Set topic, arm and count."""
        candidates = sorted({channel.topic for channel in self._files.channels
                             if topic in (None, channel.topic) and _is_readable(channel)})
        if not candidates:
            kinds = listed({f'{channel.topic} ({channel.kind}, {channel.encoding})'
                            for channel in self._files.channels})
            raise BagError(f'{self.path}: no joint states in CDR or ROS 1 encoding'
                           f'{f" on {topic}" if topic else ""}; it has {kinds or "no messages"}')
        names = {each: self._joints(each, arm) for each in candidates}
        fitting = [each for each in candidates if sides_of(names[each], arm)]
        if USUAL_TOPIC not in fitting and len(fitting) > 1:
            options = ' or '.join(f'--topic {each}' for each in fitting)
            raise BagError(f"{self.path}: several topics have an arm's joints: choose {options}")
        self.topic = USUAL_TOPIC if USUAL_TOPIC in fitting else (fitting or candidates)[0]
        self.arm = choose_arm(f'{self.path}: {self.topic}', names[self.topic], arm)
        self.count = self._count(self.topic)

    def _count(self, topic: str) -> int:
        return sum(channel.count for channel in self._files.channels
                   if channel.topic == topic and _is_readable(channel))

    def _joints(self, topic: str, arm: 'str | None') -> set[str]:
        """Return joints on a topic: of the first messages, and until there are an arm's."""
        names: set[str] = set()
        for i, state in enumerate(self._play(topic)):
            names.update(state.names)
            if i >= _PEEK and sides_of(names, arm):
                break
        return names

    def _play(self, topic: str) -> Iterator[JointState]:
        missing = self._count(topic)
        try:
            for channel, received_ns, raw in self._files.messages(topic):
                if _is_readable(channel):
                    missing -= 1
                    yield self._state(channel, received_ns, raw)
        except Exception as error:  # a damaged file makes the libraries raise anything
            raise bag_error(self.path, error) from None
        if missing > 0:  # a library may skip records that it does not know
            raise BagError(f'{self.path}: {missing} messages on {topic} are missing: the bag is '
                           'damaged')

    def _state(self, channel: Channel, received_ns: int, raw: bytes) -> JointState:
        try:
            message = _decode(channel.encoding, raw)
        except Exception as error:  # a damaged message makes the parser raise anything
            raise BagError(f'{self.path}: {channel.topic}: the message received at {received_ns} '
                           f'ns is not a joint state ({error})') from None
        stamp = message.header.stamp
        return JointState(stamp.sec * 10**9 + stamp.nanosec, message.name, message.position,
                          message.velocity, message.effort, received_ns)


def _is_readable(channel: Channel) -> bool:
    return channel.kind == JOINT_STATE and channel.encoding in ('cdr', 'ros1')


def _decode(encoding: str, raw: bytes) -> Any:
    if encoding == 'ros1':
        return type_store(Stores.ROS1_NOETIC).deserialize_ros1(raw, JOINT_STATE)
    decode = type_store(Stores.ROS2_JAZZY).deserialize_cdr
    for padding in _PADDING:
        try:
            return decode(raw[:len(raw) - padding], JOINT_STATE)
        except SerdeError as error:  # a message of another length
            problem = error
    raise problem


@dataclass(eq=False)
class ArrayRecording:
    """One recording of an array file; behaves like :class:`BagRecording`."""

    name: str
    arm: str
    count: int
    joints: list[str]  # names of j joints
    stamps_ns: Any  # (n,) [ns]
    arrays: tuple[Array, ...]  # position [rad], velocity [rad/s] and effort [N m], (n, j) each
    topic: str = USUAL_TOPIC

    def __enter__(self) -> 'ArrayRecording':
        """Return the recording."""
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        """Do nothing: the arrays stay."""

    def __iter__(self) -> Iterator[JointState]:
        """Yield each joint state; the stamp is also the time of recording."""
        for stamp_ns, position, velocity, effort in zip(self.stamps_ns.tolist(), *self.arrays):
            yield JointState(stamp_ns, self.joints, position, velocity, effort, stamp_ns)


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
        recordings.append(ArrayRecording(
            name, choose_arm(f'{path}: {name}', set(joints), arm), len(rows), joints,
            _stamps_ns(contents, rows), arrays))
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

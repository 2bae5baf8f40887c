"""New recordings: joint states, and whatever another bag holds, into a rosbag2 folder."""

from collections import Counter
from collections.abc import Iterable
import os
from pathlib import Path
import shutil
import struct
import tempfile
from types import TracebackType
from typing import Literal

import numpy as np
from rosbags.convert.converter import LATCH
from rosbags.interfaces import Connection, ConnectionExtRosbag1, ConnectionExtRosbag2, Qos
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.typesys import get_typestore, Stores, TypesysError

from .definitions import is_ros1, JOINT_STATE, ros2, standard_types, types_of, UnknownTypeError
from .diagnosis import BagError
from ..model.arrays import ArrayLike

_FAILURES = (OSError, OverflowError, WriterError)
_VERSION: Literal[9] = 9  # of rosbag2's metadata: Jazzy's


class BagWriter:
    """
    Write a new rosbag2 folder (MCAP), which is there when it is complete, or not at all.

    A context manager: the folder gets its name when the block ends without an exception.

    Parameters
    ----------
    path : Path
        The folder; it must not exist, its parent must.
    reserved : iterable of str, optional
        Topics for :meth:`joint_state` alone: :meth:`copy` skips them.

    Raises
    ------
    BagError
        If the folder exists or cannot be written; from any method.

    """

    def __init__(self, path: Path, reserved: Iterable[str] = ()) -> None:
        self.path = Path(path)
        self._refuse_existing()
        if not os.path.isdir(self.path.parent):
            raise BagError(f'{self.path}: there is no folder {self.path.parent} to write it to')
        self._reserved = frozenset(reserved)
        self._types = get_typestore(Stores.EMPTY)
        self._types.register(standard_types(JOINT_STATE))
        self._joint_states: dict[str, Connection] = {}  # by topic
        # (Reader, connection id) -> connection; None for what is skipped.
        self._copies: dict[tuple[object, int], Connection | None] = {}
        self._reasons: dict[str, str] = {}  # topic -> why it is skipped
        self._skips: Counter[str] = Counter()  # topic -> messages

    def __enter__(self) -> 'BagWriter':
        """Begin, under a hidden name beside the folder's."""
        try:
            self._temporary = Path(tempfile.mkdtemp(prefix=f'.{self.path.name}.',
                                                    dir=self.path.parent))
        except OSError as error:
            raise self._failure(error) from None
        try:
            self._writer = Writer(self._temporary / self.path.name, version=_VERSION,
                                  storage_plugin=StoragePlugin.MCAP)
            self._writer.open()
        except BaseException as error:
            shutil.rmtree(self._temporary, ignore_errors=True)
            if isinstance(error, _FAILURES):
                raise self._failure(error) from None
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        """Complete the folder and give it its name, or remove it after an exception."""
        try:
            self._writer.__exit__(kind, error, trace)
            if kind is None:
                self._refuse_existing()
                os.rename(self._temporary / self.path.name, self.path)
        except _FAILURES as failure:
            raise self._failure(failure) from None
        finally:
            shutil.rmtree(self._temporary, ignore_errors=True)

    @property
    def skipped(self) -> dict[str, str]:
        """Return what was not copied: topic -> why, and how many messages."""
        return {topic: f'{reason} ({self._skips[topic]} messages)'
                for topic, reason in self._reasons.items()}

    def joint_state(self, topic: str, stamp_ns: int, names: Iterable[str], position: ArrayLike,
                    velocity: ArrayLike = (), effort: ArrayLike = (),
                    received_ns: int | None = None, frame: str = '') -> None:
        """
        Write a joint state.

        Parameters
        ----------
        topic : str
            Where it belongs.
        stamp_ns : int
            Its stamp [ns].
        names : sequence of str
            Its joints.
        position, velocity, effort : array_like
            In rad, rad/s, N m, in the order of names; may be empty.
        received_ns : int, optional
            When it was received [ns]; by default its stamp.
        frame : str
            Its ``frame_id``.

        """
        connection = self._joint_states.get(topic)
        if connection is None:
            connection = self._joint_states[topic] = self._connect(topic, JOINT_STATE, [])
        try:
            raw = self._serialise(stamp_ns, frame, tuple(names), (position, velocity, effort))
        except struct.error:
            raise BagError(f'{self.path}: {topic}: no message can have the stamp '
                           f'{stamp_ns} ns') from None
        self._write(connection, stamp_ns if received_ns is None else received_ns, raw)

    def copy(self, connection: Connection, received_ns: int, raw: bytes | memoryview) -> None:
        """
        Write a message of another bag, of ROS 1 or 2; what cannot be copied is counted.

        Parameters
        ----------
        connection : rosbags.interfaces.Connection
            The other bag's topic, with its type and how it was offered.
        received_ns : int
            When the message was received [ns].
        raw : bytes
            The message, as the other bag has it.

        """
        topic, name = connection.topic, connection.msgtype
        key = (connection.owner, connection.id)
        if key not in self._copies:
            try:
                self._copies[key] = self._prepare(connection)
            except UnknownTypeError as error:
                self._copies[key] = None
                self._reasons.setdefault(topic, str(error))
        target = self._copies[key]
        if target is not None and is_ros1(connection):
            try:
                raw = self._types.ros1_to_cdr(raw, name)
            except Exception as error:  # of generated code: whatever a broken message leads it to
                target = None
                self._reasons.setdefault(topic, f'broken messages: {error}')
        if target is None:
            self._skips[topic] += 1
        else:
            self._write(target, received_ns, raw)

    def _prepare(self, connection: Connection) -> Connection:
        """Return where a connection's messages are copied to."""
        topic, name, ext = connection.topic, connection.msgtype, connection.ext
        if topic in self._reserved:
            raise UnknownTypeError('the new bag has its own')
        if isinstance(ext, ConnectionExtRosbag2) and ext.serialization_format != 'cdr':
            raise UnknownTypeError(f'its messages are {ext.serialization_format}, not CDR')
        try:
            self._types.register(types_of(connection))
        except TypesysError:
            raise UnknownTypeError(f'its type {name}, or one it is made of, is defined otherwise '
                                   'by another topic') from None
        if isinstance(ext, ConnectionExtRosbag1):
            return self._connect(topic, name, LATCH if ext.latching else [])
        return self._connect(topic, name, ext.offered_qos_profiles)

    def _connect(self, topic: str, name: str, profiles: list[Qos]) -> Connection:
        """Return the new bag's connection of that kind; a topic may have several."""
        ext = ConnectionExtRosbag2('cdr', profiles)
        for known in self._writer.connections:
            if (known.topic, known.msgtype, known.ext) == (topic, name, ext):
                return known
        try:
            return self._writer.add_connection(topic, name, typestore=self._types,
                                               offered_qos_profiles=profiles)
        except _FAILURES as error:
            raise self._failure(error) from None

    def _serialise(self, stamp_ns: int, frame: str, names: tuple[str, ...],
                   arrays: Iterable[ArrayLike]) -> memoryview:
        types = ros2().types
        stamp = types['builtin_interfaces/msg/Time'](*divmod(stamp_ns, 10**9))
        header = types['std_msgs/msg/Header'](stamp, frame)
        values = [np.ascontiguousarray(array, dtype=float) for array in arrays]
        return ros2().serialize_cdr(types[JOINT_STATE](header, list(names), *values), JOINT_STATE)

    def _write(self, connection: Connection, received_ns: int, raw: bytes | memoryview) -> None:
        try:
            self._writer.write(connection, received_ns, raw)
        except _FAILURES as error:
            raise self._failure(error) from None

    def _refuse_existing(self) -> None:
        if os.path.lexists(self.path):
            raise BagError(f'{self.path}: exists; name a new folder, or remove it first')

    def _failure(self, error: Exception) -> BagError:
        return BagError(f'{self.path}: cannot be written ({error})')

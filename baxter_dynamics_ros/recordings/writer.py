"""Writer of joint states, such as predictions for a recording, to a new rosbag2 folder."""

from collections.abc import Iterable
from contextlib import ExitStack
import os
from pathlib import Path
import struct
from typing import Any

import numpy as np
from rosbags.interfaces import Connection
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.typesys import get_typestore, Stores

from .diagnosis import BagError
from .playback import Recording
from ..estimation.predictor import Predictor
from ..estimation.settings import PredictorSettings
from ..files import staged
from ..model.arrays import ArrayLike
from ..model.joints import BASE_FRAME, joint_names

JOINT_STATE = 'sensor_msgs/msg/JointState'
_TYPES = get_typestore(Stores.ROS2_JAZZY)


class BagWriter:
    """
    Writer of a new rosbag2 folder (MCAP); a context manager.

    The folder appears when the block ends without an exception.

    Parameters
    ----------
    path : Path
        The folder. It must not exist; its parent must.

    Raises
    ------
    BagError
        If the folder exists or cannot be written; also from the methods.

    """

    def __init__(self, path: Path) -> None:
        self.path = Path(path)
        self._refuse_existing()
        if not os.path.isdir(self.path.parent):
            raise BagError(f'{self.path}: no folder {self.path.parent}')
        self._connections: dict[str, Connection] = {}  # by topic
        self._stack = ExitStack()

    def __enter__(self) -> 'BagWriter':
        """Begin a hidden folder beside the target."""
        with ExitStack() as stack:
            stage = stack.enter_context(staged(self.path.parent, self.path.name))
            stack.callback(self._refuse_existing)  # it may have been created meanwhile
            self._writer = stack.enter_context(Writer(
                stage / self.path.name, version=9, storage_plugin=StoragePlugin.MCAP))
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *exception: Any) -> None:
        """Complete the folder, or remove it after an exception."""
        self._stack.__exit__(*exception)

    def joint_state(self, topic: str, stamp_ns: int, names: Iterable[str], position: ArrayLike,
                    velocity: ArrayLike = (), effort: ArrayLike = (),
                    received_ns: int | None = None, frame: str = '') -> None:
        """
        Write a joint state with values in rad, rad/s and N m, which may be empty.

        The time of recording, received_ns, is the stamp by default; frame is ``frame_id``.
        """
        types = _TYPES.types
        try:
            message = types[JOINT_STATE](
                types['std_msgs/msg/Header'](
                    types['builtin_interfaces/msg/Time'](*divmod(stamp_ns, 10**9)), frame),
                list(names), *(np.ascontiguousarray(array, dtype=float)
                               for array in (position, velocity, effort)))
            raw = _TYPES.serialize_cdr(message, JOINT_STATE)
            if topic not in self._connections:
                self._connections[topic] = self._writer.add_connection(
                    topic, JOINT_STATE, typestore=_TYPES)
            self._writer.write(self._connections[topic],
                               stamp_ns if received_ns is None else received_ns, raw)
        except (OverflowError, WriterError, struct.error) as error:
            raise BagError(f'{self.path}: {topic}: cannot be written ({error})') from None

    def _refuse_existing(self) -> None:
        if os.path.lexists(self.path):
            raise BagError(f'{self.path}: exists; choose a new folder or remove it first')


def save_predictions(recording: Recording, settings: PredictorSettings, writer: BagWriter,
                     node: str) -> None:
    """Write predicted effort, residual and external effort as a node would publish them."""
    predictor = Predictor(settings, external=True)
    names = joint_names(recording.arm)
    for stamp_ns, joints, position, velocity, effort, received_ns in recording:
        step = predictor.handle(stamp_ns, joints, position, velocity, effort)
        prediction, external = step.prediction, step.external
        for topic, result, values in (
                ('predicted_effort', prediction, prediction and prediction.effort),
                ('effort_residual', prediction, prediction and prediction.residual),
                ('external_effort', external, external and external.effort)):
            if result is not None and values is not None:
                writer.joint_state(f'{node}/{topic}', result.stamp_ns, names, result.q, result.qd,
                                   values, received_ns, BASE_FRAME)

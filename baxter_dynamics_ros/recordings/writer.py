"""Writer of joint states, such as predictions for a recording, to a new rosbag2 folder."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import struct
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.typesys import Stores

from .bag_files import JOINT_STATE, type_store
from .recording import BagError, Recording
from ..estimation.predictor import Predictor
from ..estimation.settings import PredictorSettings
from ..files import staged
from ..model.arrays import ArrayLike
from ..model.joints import BASE_FRAME, joint_names


class BagWriter:
    """Writer of joint states to an open bag; see :func:`new_bag`."""

    def __init__(self, path: Path, bag: Writer) -> None:
        self.path = path
        self._bag = bag
        self._connections: dict[str, Any] = {}  # topic to connection

    def joint_state(self, topic: str, stamp_ns: int, names: Iterable[str], position: ArrayLike,
                    velocity: ArrayLike = (), effort: ArrayLike = (),
                    received_ns: int | None = None, frame: str = '') -> None:
        """
        Write a joint state with values in rad, rad/s and N m, which may be empty.

        The time of recording, received_ns, is the stamp by default; frame is ``frame_id``.
        """
        store = type_store(Stores.ROS2_JAZZY)
        try:
            message = store.types[JOINT_STATE](
                store.types['std_msgs/msg/Header'](
                    store.types['builtin_interfaces/msg/Time'](*divmod(stamp_ns, 10**9)), frame),
                list(names), *(np.ascontiguousarray(array, dtype=float)
                               for array in (position, velocity, effort)))
            raw = store.serialize_cdr(message, JOINT_STATE)
            if topic not in self._connections:
                self._connections[topic] = self._bag.add_connection(
                    topic, JOINT_STATE, typestore=store)
            self._bag.write(self._connections[topic],
                            stamp_ns if received_ns is None else received_ns, raw)
        except (OverflowError, WriterError, struct.error) as error:
            raise BagError(f'{self.path}: {topic}: cannot be written ({error})') from None


@contextmanager
def new_bag(path: str | Path) -> Iterator[BagWriter]:
    """
    Provide a writer of a new rosbag2 folder (MCAP), which appears when the block succeeds.

    Raises BagError, also from the writer, if the folder exists or cannot be written.
    """
    path = Path(path)
    _refuse_existing(path)
    if not path.parent.is_dir():
        raise BagError(f'{path}: no folder {path.parent}')
    with staged(path.parent, path.name) as stage:
        with Writer(stage / path.name, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
            yield BagWriter(path, bag)
        _refuse_existing(path)  # it may have been created meanwhile


def _refuse_existing(path: Path) -> None:
    if os.path.lexists(path):
        raise BagError(f'{path}: exists; choose a new folder or remove it first')


def save_predictions(recording: Recording, settings: PredictorSettings, writer: BagWriter,
                     node: str) -> None:
    """Write the efforts, residuals and their deviations that a node would publish."""
    predictor = Predictor(settings, external=True)
    names = joint_names(recording.arm)
    for state in recording:
        step = predictor.handle(*state)
        found: list[tuple[str, Any, Any]] = []  # topic, its instant and motion, its effort
        if step.prediction is not None:
            found.append(('predicted_effort', step.prediction, step.prediction.effort))
            if step.prediction.residual is not None:
                found += [('effort_residual', step.prediction, step.prediction.residual),
                          ('residual_deviation', step.prediction, step.prediction.deviation)]
        if step.external is not None:
            found.append(('external_effort', step.external, step.external.effort))
        for topic, at, values in found:
            writer.joint_state(f'{node}/{topic}', at.stamp_ns, names, at.q, at.qd, values,
                               state.received_ns, BASE_FRAME)

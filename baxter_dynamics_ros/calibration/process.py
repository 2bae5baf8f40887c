"""
Calibration in a process of its own: ``python -m baxter_dynamics_ros.calibration.process``.

Its arguments are an .npz file of joint states from :func:`write_input` and the file for a JSON
object with the fields of :class:`Result`. Only the process itself needs SciPy.
"""

from collections.abc import Iterator
import json
import os
from pathlib import Path
import sys
from typing import Any, NamedTuple

import numpy as np

from ..estimation.settings import PredictorSettings
from ..files import write_file
from ..model.arrays import Array
from ..model.exceptions import BaxterDynamicsError
from ..model.joints import N_JOINTS
from ..recordings.recording import JointState

COMMAND = (sys.executable, '-m', __name__ if __name__ != '__main__' else str(__spec__.name))
# For the process: one thread, so that the fit leaves the other processors alone.
ENVIRONMENT = {'OMP_NUM_THREADS': '1', 'OPENBLAS_NUM_THREADS': '1', 'MKL_NUM_THREADS': '1'}

_NICE = 10


class Result(NamedTuple):
    """Result of a calibration."""

    message: str  # reason of a refusal, otherwise the residuals
    better: bool = False  # whether the calibration predicts left-out parts better
    values: dict[str, Any] = {}  # settings that the calibration changed
    rms_before: list[float] = [np.nan] * N_JOINTS  # (7,) on parts left out of the fit [N m]
    rms_after: list[float] = [np.nan] * N_JOINTS
    notices: list[str] = []  # warnings about data and fit


def write_input(path: Path, names: list[str], stamps_ns: list[int], received_ns: list[int],
                arrays: tuple[Array, Array, Array], settings: PredictorSettings,
                inertial: bool = False, payload: bool = False) -> None:
    """
    Write joint states of one arm and the request.

    Parameters
    ----------
    path : Path
        File to write.
    names : list of str
        Names of j joints, the columns of the arrays.
    stamps_ns, received_ns : list of int, n each
        Header stamps and times of receipt [ns].
    arrays : tuple of ndarray (n, j)
        Position [rad], velocity [rad/s] and effort [N m]; NaN where missing.
    settings : PredictorSettings
        Present settings, from which the calibration starts.
    inertial, payload : bool
        Whether to fit links and payload.

    """
    request = {'names': names, 'values': settings.parameters(), 'inertial': inertial,
               'payload': payload}
    position, velocity, effort = arrays
    np.savez(path, stamp=stamps_ns, received=received_ns, position=position, velocity=velocity,
             effort=effort, request=json.dumps(request))


def read_result(path: Path) -> Result:
    """Return the result that the process has written."""
    return Result(**json.loads(path.read_text()))


class _Recording:
    """Joint states of an input file."""

    name, topic = 'the recording', ''

    def __init__(self, file: dict[str, Any], names: list[str], arm: str) -> None:
        self.arm = arm
        self.count = len(file['stamp'])
        self._names = names
        self._file = file

    def __iter__(self) -> Iterator[JointState]:
        keys = ('stamp', 'position', 'velocity', 'effort', 'received')
        for stamp, q, qd, effort, received in zip(*(self._file[key] for key in keys)):
            yield JointState(int(stamp), self._names, q, qd, effort, int(received))


def run(path: Path) -> Result:
    """Return the calibration to the joint states of an input file."""
    try:
        from .calibrate_robot import calibrate
    except ImportError as error:
        return Result(f'calibration needs SciPy: pip install scipy, or python3-scipy from apt '
                      f'({error})')
    with np.load(path) as file:
        contents = {key: file[key] for key in file.files}
    request = json.loads(str(contents['request']))
    settings = PredictorSettings.from_parameters(request['values'])
    recording = _Recording(contents, request['names'], settings.arm)
    try:
        found = calibrate([recording], settings, request['inertial'], request['payload'])
    except BaxterDynamicsError as error:
        return Result(str(error))
    before = settings.parameters()
    changed = {name: value for name, value in found.after.parameters().items()
               if value != before[name]}
    return Result(found.summary, found.better, changed, found.rms_before.tolist(),
                  found.rms_after.tolist(), list(found.warnings))


def main(path: str, output: str) -> None:
    """Calibrate at low priority, and write the result."""
    os.nice(_NICE)
    result = run(Path(path))
    write_file(output, json.dumps(result._asdict()))


if __name__ == '__main__':
    main(*sys.argv[1:])

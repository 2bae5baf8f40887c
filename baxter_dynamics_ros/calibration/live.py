"""
Calibration beside a running node: progress of the motion, and the fit in a process of its own.

``python -m baxter_dynamics_ros.calibration.live`` reads a file of :func:`write_input` and writes
the fields of :class:`Result` as JSON. Only the process needs SciPy.
"""

from collections.abc import Sequence
import json
import os
from pathlib import Path
import sys
from typing import Any, NamedTuple

import numpy as np

from ..estimation.settings import PredictorSettings
from ..files import write_file
from ..model import Array, BaxterDynamicsError, JOINTS, N_JOINTS
from ..recordings.recording import ArrayRecording

COMMAND = (sys.executable, '-m', 'baxter_dynamics_ros.calibration.live')
# For the process: one thread, so that the fit leaves the other processors alone.
ENVIRONMENT = {'OMP_NUM_THREADS': '1', 'OPENBLAS_NUM_THREADS': '1', 'MKL_NUM_THREADS': '1'}

_NICE = 10
_COLUMNS = 'stamp', 'received', 'position', 'velocity', 'effort'  # of an input file
_STEP = 0.2  # time between the positions that are compared, long for their quantisation [s]
_DURATION = 20.0  # for which acceleration must last [s]

# Motion that identifies the parameters of a joint, measured on recordings and on the exciting
# trajectory: minimum, and advice for joints that lack it.
_REQUIRED = (
    (0.8, 'move {} through more of the range'),  # [rad]
    (0.2, 'move {} faster in the positive direction'),  # [rad/s]
    (0.2, 'move {} faster in the negative direction'),  # [rad/s]
    (0.15, 'accelerate {} more'),  # RMS over _DURATION [rad/s^2]
)


def progress(time: Array, q: Array) -> tuple[Array, str]:
    """
    Return the share of the required motion that was seen, (7,), and advice on the rest.

    Positions q are (n, 7) [rad], at increasing times (n,) [s]. They give speed and acceleration
    too, because measured velocities have too much noise on some arms.
    """
    shares = np.zeros((len(_REQUIRED), N_JOINTS))
    stride = max(round(_STEP / float(np.median(np.diff(time)))), 1) if len(time) > 1 else 1
    t, q = time[::stride], q[::stride]
    if len(t) > 2:
        speed = np.diff(q, axis=0) / np.diff(t)[:, None]
        square = np.diff(speed, axis=0) ** 2 / (0.5 * (t[2:] - t[:-2]))[:, None]
        shown = np.stack([np.ptp(q, axis=0), speed.max(0), -speed.min(0),
                          np.sqrt(square.sum(0) / _DURATION)])
        shares = np.clip(shown / np.array([[least] for least, _ in _REQUIRED]), 0.0, 1.0)
    worst = int(np.argmin(shares.mean(1)))
    lacking = ', '.join(JOINTS[i] for i in np.flatnonzero(shares[worst] < 1.0))
    return shares.min(0), (_REQUIRED[worst][1].format(lacking) if lacking else
                           'all joints have moved enough; further motion improves the result')


class Result(NamedTuple):
    """Result of a calibration."""

    message: str  # reason of a refusal, otherwise the residuals
    better: bool = False  # whether the calibration predicts left-out parts better
    values: dict[str, Any] = {}  # settings that the calibration changed
    rms_before: list[float] = [np.nan] * N_JOINTS  # (7,) on parts left out of the fit [N m]
    rms_after: list[float] = [np.nan] * N_JOINTS
    notices: list[str] = []  # warnings about data and fit


def write_input(path: Path, names: list[str], rows: Sequence[tuple[Any, ...]],
                settings: PredictorSettings, inertial: bool = False, payload: bool = False
                ) -> None:
    """
    Write joint states of one arm, the settings to begin with, and what to fit on request.

    A row has stamp and time of receipt [ns], position [rad], velocity [rad/s] and effort [N m] in
    the order of the names, NaN where missing.
    """
    request = {'names': names, 'values': settings.parameters(), 'inertial': inertial,
               'payload': payload}
    columns: dict[str, Any] = dict(zip(_COLUMNS, zip(*rows)))
    np.savez(path, request=json.dumps(request), **columns)


def read_result(path: Path) -> Result:
    """Return the result that the process has written."""
    return Result(**json.loads(path.read_text()))


def run(path: Path) -> Result:
    """Return the calibration to the joint states of an input file."""
    from .calibrate_robot import calibrate
    with np.load(path) as file:
        request = json.loads(str(file['request']))
        settings = PredictorSettings.from_parameters(request['values'])
        stamp, received, *arrays = (file[name] for name in _COLUMNS)
        recording = ArrayRecording('the recording', settings.arm, request['names'], stamp, arrays,
                                   received)
    try:
        found = calibrate([recording], settings, request['inertial'], request['payload'])
    except BaxterDynamicsError as error:
        return Result(str(error))
    before = settings.parameters()
    changed = {name: value for name, value in found.after.parameters().items()
               if value != before[name]}
    return Result(found.summary, found.better, changed, found.total.before.tolist(),
                  found.total.after.tolist(), list(map(str, found.notices)))


if __name__ == '__main__':
    os.nice(_NICE)
    write_file(sys.argv[2], json.dumps(run(Path(sys.argv[1]))._asdict()))

"""Action calibrate: fits the effort model to the joint states that arrive meanwhile."""

from importlib.util import find_spec
import os
from pathlib import Path
import subprocess
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from . import topics
from .messages import from_field, stamp_ns
from .ros_parameters import ParameterNode
from .step_statistics import StepStatistics
from .zero import RefusedError, WaitingRequest
from ..estimation.continuity import GAP
from ..estimation.events import Event
from ..estimation.predictor import Predictor, Step
from ..estimation.settings import PredictorSettings
from ..model import Array, BaxterDynamicsError, N_JOINTS

SHORTEST, LONGEST = 10.0, 600.0  # recording time [s]
_FEEDBACK_PERIOD = 1.0  # of recorded time [s]
_NEEDED = {'scipy': 'scipy', 'yaml': 'pyyaml'}  # module -> package
_MOST_SHOWN = 3000  # maximum number of positions from which progress is computed


class CalibrateAction(WaitingRequest):
    """
    Action server that records joint states, fits the effort model and sets parameters.

    The fit is a process of low priority, so that it does not delay predictions. ``action`` is the
    type ``baxter_dynamics_interfaces.action.Calibrate``.
    """

    def __init__(self, node: ParameterNode, predictor: Predictor, statistics: StepStatistics,
                 action: type[Any]) -> None:
        super().__init__(node, predictor, statistics)
        self._action = action
        self._names = list(predictor.stream.selector.names)
        self._elapsed = 0.0  # recorded time on the clock of the stamps [s]
        self._positions: list[tuple[float, Array]] = []  # recorded time [s], position (7,) [rad]
        self._newest_ns = 0
        self._process: subprocess.Popen[bytes] | None = None
        self._server = ActionServer(
            node, action, f'~/{topics.CALIBRATE}', self._execute, callback_group=self.group,
            cancel_callback=lambda goal: CancelResponse.ACCEPT)

    def add(self, message: JointState, received_ns: int, step: Step) -> None:
        """Record a joint state while a goal needs it, as a row of ``live.write_input``."""
        if self._kept is None:
            return
        layout = self._predictor.stream.selector.layout(message.name)
        if isinstance(layout, Event):
            return
        if step.state is not None:
            dt = min((step.state.stamp_ns - self._newest_ns) * 1e-9, GAP)
            if dt > 0.0:
                self._elapsed += dt
                self._positions.append((self._elapsed, step.state.q))
            self._newest_ns = step.state.stamp_ns
        self._kept.append((stamp_ns(message.header), received_ns, *(
            from_field(field)[layout] if len(field) == len(message.name)
            else np.full(N_JOINTS, np.nan)
            for field in (message.position, message.velocity, message.effort))))

    def destroy(self) -> None:
        """End the fit and the server."""
        self._end_fit()
        self._server.destroy()

    async def _execute(self, handle: ServerGoalHandle) -> Any:
        result = self._action.Result(joint_names=self._names)
        try:
            with self._only('calibration'), TemporaryDirectory(
                    prefix='calibration', ignore_cleanup_errors=True) as path:
                self._refuse(handle.request)
                await self._record(handle, Path(path))
                self._use(await self._fit(handle, Path(path)), handle.request.file, result)
            handle.succeed()
        except (RefusedError, OSError) as error:
            result.message = f'nothing was changed: {error}'
            if handle.is_cancel_requested:
                handle.canceled()
            else:
                handle.abort()
        return result

    def _refuse(self, goal: Any) -> None:
        """Raise RefusedError if a goal cannot be reached."""
        if not SHORTEST <= goal.duration <= LONGEST:
            raise RefusedError(f'duration: expected {SHORTEST:g} to {LONGEST:g} s, got '
                               f'{goal.duration:g}')
        missing = ' '.join(package for module, package in _NEEDED.items()
                           if find_spec(module) is None)
        if missing:
            raise RefusedError(f'calibration needs {missing}: pip install {missing}')
        if goal.file and not os.access(Path(goal.file).absolute().parent, os.W_OK):
            raise RefusedError(f'file: cannot write to the folder of {goal.file}')

    async def _record(self, handle: ServerGoalHandle, folder: Path) -> None:
        """Record joint states for the duration of the goal, and write the input of the fit."""
        from ..calibration.live import progress, write_input
        goal, reported = handle.request, 0.0
        self._kept = rows = list[Any]()
        self._elapsed, self._positions, self._newest_ns = -GAP, [], 0  # 0.0 at the first state
        while self._elapsed < goal.duration:
            self._refuse_old_states()
            state = self._statistics.accepted.state
            if state and state.effort is None:
                raise RefusedError('there is no measured effort: see the status effort')
            if self._elapsed - reported > _FEEDBACK_PERIOD:
                reported = self._elapsed
                shown = self._positions[::len(self._positions) // _MOST_SHOWN + 1]
                seen, advice = progress(*map(np.array, zip(*shown)))
                handle.publish_feedback(self._action.Feedback(
                    elapsed=reported, joint_names=self._names, seen=seen.tolist(), advice=advice))
            await self._wait(handle)
        self._kept = None
        write_input(folder / 'in.npz', self._names, rows,
                    PredictorSettings.from_parameters(self._node.values), goal.inertial,
                    goal.payload)

    async def _fit(self, handle: ServerGoalHandle, folder: Path) -> Any:
        """Return the result of the fit."""
        from ..calibration.live import COMMAND, ENVIRONMENT, read_result
        found, log = folder / 'out.json', folder / 'log'
        with open(log, 'w') as output:
            self._process = subprocess.Popen(
                [*COMMAND, str(folder / 'in.npz'), str(found)], stdin=subprocess.DEVNULL,
                stdout=output, stderr=output, env={**os.environ, **ENVIRONMENT})
        try:
            while self._process.poll() is None:
                await self._wait(handle)
        finally:
            self._end_fit()
        if not found.exists():
            raise RefusedError('the fit failed: ' + (
                log.read_text().strip().splitlines() or ['no output'])[-1])
        return read_result(found)

    def _use(self, found: Any, file: str, result: Any) -> None:
        """Set the fitted parameters if they are better, and write the file."""
        from ..recordings.parameter_file import write_parameters
        if np.isfinite([found.rms_before, found.rms_after]).all():
            result.rms_before, result.rms_after = found.rms_before, found.rms_after
        if not found.better:
            raise RefusedError(found.message)
        parameters = [Parameter(name, value=value) for name, value in found.values.items()]
        self._set(parameters)
        result.success = True
        result.parameters = [parameter.to_parameter_msg() for parameter in parameters]
        result.message = '; '.join([found.message, *found.notices])
        if file:
            try:
                write_parameters(file, PredictorSettings.from_parameters(self._node.values),
                                 ['Calibrated by the action calibrate.', found.message,
                                  *found.notices])
                result.file = file
            except (OSError, BaxterDynamicsError) as error:
                result.message += f'; the file was not written: {error}'

    async def _wait(self, handle: ServerGoalHandle) -> None:
        await self._pause()
        if handle.is_cancel_requested:
            raise RefusedError('the goal was cancelled')

    def _end_fit(self) -> None:
        if self._process is not None:
            self._process.kill()  # has no effect once it has ended
            self._process.wait()

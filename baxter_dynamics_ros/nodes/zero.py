"""Requests that wait for joint states; service zero, which adds the mean residual to the bias."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
import time
from typing import Any

import numpy as np
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.parameter import Parameter
from rclpy.task import Future
from std_srvs.srv import Trigger

from .ros_parameters import ParameterNode
from .step_statistics import MAX_AGE, StepStatistics
from ..estimation.external import External
from ..estimation.predictor import Prediction, Predictor, Step
from ..model import BaxterDynamicsError, JOINTS, N_JOINTS

DURATION = 3.0  # time covered by the residuals, on the clock of the stamps [s]
_PATIENCE = 15.0  # maximum time for collecting them [s]
_CHECK_PERIOD = 0.1  # [s]
BIAS = 'effort_model.bias'


class RefusedError(BaxterDynamicsError):
    """A request that cannot be carried out, with the reason."""


class WaitingRequest:
    """Request whose callback waits for joint states; one runs at a time."""

    def __init__(self, node: ParameterNode, predictor: Predictor,
                 statistics: StepStatistics) -> None:
        self._node = node
        self._predictor = predictor
        self._statistics = statistics
        self._values: dict[str, Any] | None = None  # parameters at the beginning of the request
        self._kept: list[Any] | None = None  # records of joint states; None while not needed
        # A mutually exclusive group blocks its other callbacks while one of them waits.
        self.group = ReentrantCallbackGroup()

    @contextmanager
    def _only(self, name: str) -> Iterator[None]:
        """Refuse a request if another is running, or if the effort model is not used."""
        if self._values is not None:
            raise RefusedError(f'another {name} is running')
        if not self._node.values['effort_model.enabled']:
            raise RefusedError('effort_model.enabled is false, so its parameters have no effect')
        self._values = self._node.values
        try:
            yield
        finally:
            self._values = self._kept = None

    async def _pause(self) -> None:
        """Let other callbacks run for a while; they must not change parameters."""
        future = Future()
        timer = self._node.create_timer(
            _CHECK_PERIOD, lambda: future.done() or future.set_result(None),
            callback_group=self.group, clock=Clock(clock_type=ClockType.STEADY_TIME))
        try:
            await future
        finally:
            self._node.destroy_timer(timer)
        if self._node.values != self._values:
            raise RefusedError('parameters were changed meanwhile')

    def _refuse_old_states(self) -> None:
        if self._statistics.age > MAX_AGE:
            raise RefusedError('no valid joint states arrive: see the status input')

    def _set(self, parameters: list[Parameter]) -> None:
        result = self._node.set_parameters_atomically(parameters)
        if not result.successful:
            raise RefusedError(result.reason)


class ZeroService(WaitingRequest):
    """
    Service that sets the bias so that the mean residual becomes zero.

    An arm with a large constant offset is in contact according to the detector. Contact is
    therefore accepted if it neither begins nor ends while residuals are collected.
    """

    def add(self, step: Step) -> None:
        """Add the results of a joint state while a request waits for them."""
        if self._kept is not None and step.dropped is None:
            self._kept.append(step)

    async def handle(self, request: Trigger.Request,
                     response: Trigger.Response) -> Trigger.Response:
        """Handle a request."""
        try:
            with self._only('request'):
                response.message = self._set_bias(*zip(*await self._collect()))
            response.success = True
        except RefusedError as error:
            response.message = f'nothing was changed: {error}'
        return response

    async def _collect(self) -> list[tuple[Prediction, External]]:
        """Return results whose residuals cover the duration."""
        self._kept = steps = list[Step]()
        limit = time.monotonic() + _PATIENCE
        while not (found := _usable(steps)) or (
                found[-1][0].stamp_ns - found[0][0].stamp_ns < DURATION * 1e9):
            self._refuse_old_states()
            if time.monotonic() > limit:
                raise RefusedError(f'no {DURATION:g} s of residuals within {_PATIENCE:g} s: see '
                                   'the statuses filter and external')
            await self._pause()
        return found

    def _set_bias(self, predictions: Sequence[Prediction], externals: Sequence[External]) -> str:
        """Set the parameter; return a description of the change."""
        residuals = np.array([prediction.residual for prediction in predictions])
        crosstalk = np.eye(N_JOINTS) + self._predictor.model.effort_model.crosstalk
        change = np.linalg.solve(crosstalk, residuals.mean(axis=0))
        self._set([Parameter(BIAS, value=(self._node.values[BIAS] + change).tolist())])
        found = ', '.join(f'{joint} {x:+.2f}' for joint, x in zip(JOINTS, change))
        spread = ', '.join(f'{x:.2f}' for x in residuals.std(axis=0))
        return (f'added to {BIAS}: {found} N m; standard deviation of the residual {spread} N m'
                + any(external.contact for external in externals)
                * '; contact was reported throughout: the bias is right only if '
                'nothing touches the arm')


def _usable(steps: list[Step]) -> list[tuple[Prediction, External]]:
    """Return results with residual and contact; raise RefusedError if some forbid the change."""
    if any(step.begins for step in steps):
        raise RefusedError('the stream restarted: see the counts of the status filter')
    if any(step.prediction and step.prediction.residual is None for step in steps):
        raise RefusedError('there is no measured effort: see the status effort')
    found = [(step.prediction, step.external) for step in steps if step.external
             and step.external.contact is not None]
    if len({external.contact for _, external in found}) > 1:
        raise RefusedError(f'contact {"ended" if found[0][1].contact else "began"} meanwhile: let '
                           'nothing touch the arm')
    return [(prediction, external) for prediction, external in found if prediction]

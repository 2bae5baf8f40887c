"""Service zero: adds the mean residual to the bias of measured effort."""

import time

import numpy as np
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from . import topics
from .ros_parameters import ParameterNode
from .services import MAX_AGE, RecentSteps
from .waiting import pause, RefusedError
from ..estimation.predictor import Predictor, Step
from ..model.arrays import Array
from ..model.joints import JOINTS, N_JOINTS

DURATION = 3.0  # of the residuals, on the clock of the stamps [s]
_PATIENCE = 15.0  # maximum time until there are enough of them [s]
_CHECK_PERIOD = 0.1  # [s]
BIAS = 'effort_model.bias'


class ZeroService:
    """
    Service that sets the bias so that the mean residual becomes zero.

    An arm with a large constant offset is in contact according to the detector. Contact is
    therefore accepted if it neither begins nor ends while residuals are collected.
    """

    def __init__(self, node: ParameterNode, predictor: Predictor, recent: RecentSteps) -> None:
        self._node = node
        self._predictor = predictor
        self._recent = recent
        self._is_running = False
        self._begin()
        self._group = ReentrantCallbackGroup()
        node.create_service(Trigger, f'~/{topics.ZERO}', self._on_request,
                            callback_group=self._group)

    def _begin(self) -> None:
        self._residuals: list[Array] = []
        self._contact: bool | None = None
        self._problem = ''
        self._begin_ns = self._end_ns = 0  # stamps of the first and last residual

    def add(self, step: Step) -> None:
        """Add the results of a joint state while a request waits for them."""
        if not self._is_running or step.dropped is not None:
            return
        external, prediction = step.external, step.prediction
        contact = None if external is None else external.contact
        if step.begins:
            self._problem = 'the joint states were interrupted'
        elif prediction is not None and prediction.residual is None:
            self._problem = 'there is no measured effort: see the status effort'
        elif contact is not None:
            if self._contact not in (None, contact):
                self._problem = (f'contact {"began" if contact else "ended"} meanwhile: let '
                                 'nothing touch the arm')
            self._contact = contact
            if prediction is not None and prediction.residual is not None:
                self._residuals.append(prediction.residual)
                self._end_ns = prediction.stamp_ns
                self._begin_ns = self._begin_ns or prediction.stamp_ns

    async def _on_request(self, request: Trigger.Request,
                          response: Trigger.Response) -> Trigger.Response:
        try:
            if self._is_running:
                raise RefusedError('another request is running')
            response.message = self._set_bias(await self._collect())
            response.success = True
        except RefusedError as error:
            response.message = f'nothing was changed: {error}'
        return response

    async def _collect(self) -> Array:
        """Return residuals (n, 7) [N m]."""
        if not self._node.values['effort_model.enabled']:
            raise RefusedError('effort_model.enabled is false, so the bias has no effect')
        self._begin()
        limit = time.monotonic() + _PATIENCE
        self._is_running = True
        try:
            while (self._end_ns - self._begin_ns) * 1e-9 < DURATION:
                if self._recent.age > MAX_AGE:
                    raise RefusedError('no valid joint states arrive: see the status input')
                if time.monotonic() > limit:
                    raise RefusedError(f'no {DURATION:g} s of residuals within {_PATIENCE:g} s: '
                                       'see the statuses filter and external')
                await pause(self._node, self._group, _CHECK_PERIOD)
                if self._problem:
                    raise RefusedError(self._problem)
        finally:
            self._is_running = False
        return np.array(self._residuals)

    def _set_bias(self, residuals: Array) -> str:
        """Set the parameter; return a description of the change."""
        crosstalk = np.eye(N_JOINTS) + self._predictor.model.effort_model.crosstalk
        change = np.linalg.solve(crosstalk, residuals.mean(axis=0))
        bias = (np.array(self._node.values[BIAS]) + change).tolist()
        result = self._node.set_parameters_atomically([Parameter(BIAS, value=bias)])
        if not result.successful:
            raise RefusedError(result.reason)
        found = ', '.join(f'{joint} {x:+.2f}' for joint, x in zip(JOINTS, change))
        spread = ', '.join(f'{x:.2f}' for x in residuals.std(axis=0))
        return (f'added to {BIAS}: {found} N m; standard deviation of the residual {spread} N m'
                + bool(self._contact) * '; contact was reported throughout, which is right only '
                'if nothing touches the arm')

"""Predictor: effort, residual and external torque of one arm from its joint states."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .arm_model import ArmModel
from .events import Event
from .external import External, ExternalEffort
from .motion_estimator import Motion, MotionEstimator
from .stream import State, Stream
from ..model.arrays import Array
from ..model.presliding import Presliding


class Estimate(NamedTuple):
    """Motion and measured effort of the arm at one instant; read-only (7,) in joint order."""

    # The instant [ns], on the clock of the joint states' stamps: int, or as many in a batch.
    stamp_ns: Any
    q: Array  # position [rad]
    qd: Array  # velocity [rad/s]
    qdd: Array  # acceleration [rad/s^2]
    measured: 'Array | None'  # effort [N m]
    presliding: Array  # Dahl's state [-]


class Prediction(NamedTuple):
    """Predicted effort and residual at one instant; read-only arrays (7,) in joint order."""

    # The instant [ns], on the clock of the joint states' stamps: int, or as many in a batch.
    stamp_ns: Any
    q: Array  # position [rad]
    qd: Array  # velocity [rad/s]
    qdd: Array  # acceleration [rad/s^2]
    tau: Array  # M(q) qdd + C(q, qd) qd + G(q) [N m]
    effort: Array  # the measured effort that tau predicts [N m]
    residual: 'Array | None'  # measured - predicted effort [N m]; None without a measurement


class Step(NamedTuple):
    """Everything that one joint state gave; None where it gave nothing."""

    dropped: 'Event | None' = None  # the reason, where the message was not accepted
    begins: bool = False  # the stream restarted: earlier predictions are of another time line
    state: 'State | None' = None  # measured state
    estimate: 'Estimate | None' = None  # None while the filter settles
    prediction: 'Prediction | None' = None
    external: 'External | None' = None

    @property
    def delay(self) -> 'float | None':
        """Time from the instant of the estimate to the measured state [s]."""
        return self._since(self.estimate)

    @property
    def external_delay(self) -> 'float | None':
        """Time from the instant of the external torque to the measured state [s]."""
        return self._since(self.external)

    def _since(self, result: 'Estimate | External | None') -> 'float | None':
        if self.state is None or result is None:
            return None
        return float(self.state.stamp_ns - result.stamp_ns) * 1e-9


class Predictor:
    """
    Predict one arm's effort from its joint states, and estimate the external torque.

    The same code serves the node and recordings; it knows no ROS and no clock but the stamps.
    :meth:`handle` is :meth:`estimate`, which processes messages in order, and then
    :meth:`predict`, which has no memory and accepts many stacked estimates as well as one.

    Parameters
    ----------
    stream : Stream
        Validates joint states.
    model : ArmModel
        Torques, momentum and effort.
    estimator : MotionEstimator
        Velocities, accelerations and their alignment.
    external : ExternalEffort, optional
        Estimates the external torque; without it there is none.

    Attributes
    ----------
    counts : Counter
        The stream's: number of occurrences of each :class:`Event`, 'received' and 'taken'; and
        under 'predicted' and 'external' the messages with an estimate and an external torque.

    """

    def __init__(self, stream: Stream, model: ArmModel, estimator: MotionEstimator,
                 external: ExternalEffort | None = None) -> None:
        self.stream = stream
        self.counts = stream.counts
        self.model = model
        self.estimator = estimator
        self.external = external
        self._presliding = Presliding(model.effort_model.dahl_length)

    def configure(self, model: ArmModel) -> None:
        """Change the model in mid-stream: it holds from the next message on."""
        if not self.model.effort_model.has_dahl:
            self._presliding.reset()  # it stood still
        self.model = model
        self._presliding.length = model.effort_model.dahl_length
        if self.external is not None:
            self.external.configure(model)

    def reset(self) -> None:
        """Forget the stream, and what was learned of free motion; the counts stay."""
        self.stream.reset()
        if self.external is not None:
            self.external.reset()

    def handle(self, stamp_ns: int, names: Sequence[str], position: Array, velocity: Array,
               effort: Array, received_ns: 'int | None' = None) -> Step:
        """
        Process a joint state.

        Parameters
        ----------
        stamp_ns : int
            Its stamp [ns].
        names : sequence of str
            Its joints, in any order, other joints among them.
        position, velocity, effort : ndarray
            As long as names, in rad, rad/s, N m; velocity and effort may be empty. NaN means "not
            available".
        received_ns : int, optional
            Time of receipt [ns]: replaces stamps that are zero, and, with the setting stamps at
            'receipt', or at 'auto' where they stand still, all stamps.

        Returns
        -------
        Step
            The prediction is for ``stamp_ns``, or the re-timed stamp, less the estimator's delay.

        """
        step = self.estimate(stamp_ns, names, position, velocity, effort, received_ns)
        if step.estimate is None:
            return step
        return step._replace(prediction=self.predict(step.estimate))

    def estimate(self, stamp_ns: int, names: Sequence[str], position: Array, velocity: Array,
                 effort: Array, received_ns: 'int | None' = None) -> Step:
        """Process a joint state, as :meth:`handle` does, without predicting its effort."""
        found = self.stream.take(stamp_ns, names, position, velocity, effort, received_ns)
        if isinstance(found, Event):
            return Step(dropped=found)
        if isinstance(found, State):  # without a place on the time line yet
            return Step(begins=True, state=found)
        state, dt, begins = found
        if begins:
            self._restart()
        motions = self.estimator.update(dt, state.q, state.qd, state.effort)
        external = None
        if self.external is not None and (begins or dt > 0.0):
            external = self.external.update(state.stamp_ns, dt, motions)
            self.counts['external'] += external is not None
        return Step(None, begins, state, self._estimate(state, motions.accelerated),
                    external=external)

    def _estimate(self, state: State, motion: 'Motion | None') -> 'Estimate | None':
        if motion is None:
            return None
        self.counts['predicted'] += 1
        if self.model.effort_model.has_dahl:
            self._presliding.update(motion.q)
        return Estimate(state.stamp_ns - round(motion.delay * 1e9), *motion[1:],
                        self._presliding.z)

    def predict(self, estimate: Estimate) -> Prediction:
        """
        Predict the effort of an estimate.

        Parameters
        ----------
        estimate : Estimate
            Its arrays may have leading axes: a batch.

        """
        stamp_ns, q, qd, qdd, measured, presliding = estimate
        model = self.model.effort_model
        tau = self.model.inverse_dynamics(q, qd, qdd)
        effort = model.effort(tau, q, qd, qdd, presliding)
        held = int(np.count_nonzero(model.spring_is_held(q)))
        if held:
            self.counts[Event.SPRING_HELD] += held
        residual = None
        if measured is not None:
            residual = measured - effort
            residual.setflags(write=False)
        for array in (q, qd, qdd, tau, effort):
            array.setflags(write=False)
        return Prediction(stamp_ns, q, qd, qdd, tau, effort, residual)

    def _restart(self) -> None:
        self.estimator.reset()
        self._presliding.reset()
        if self.external is not None:
            self.external.restart()

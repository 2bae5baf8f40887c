"""Predictor: effort, residual and external torque of one arm from its joint states."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from .events import Event
from .external import External, ExternalEffort
from .motion_estimator import Estimate, MotionEstimator
from .settings import PredictorSettings
from .stream import State, Stream
from ..model import Array


class Prediction(NamedTuple):
    """Predicted effort and residual at one instant; read-only arrays (7,) in joint order."""

    stamp_ns: Any  # the instant [ns], on the clock of the stamps: int, or an array in a batch
    q: Array  # position [rad]
    qd: Array  # velocity [rad/s]
    qdd: Array  # acceleration [rad/s^2]
    tau: Array  # M(q) qdd + C(q, qd) qd + G(q) [N m]
    effort: Array  # predicted measured effort: tau plus the effort model [N m]
    residual: 'Array | None'  # measured - predicted effort [N m]; None without a measurement
    deviation: Array  # expected standard deviation of the residual [N m]


class Step(NamedTuple):
    """Results of one joint state; None where there is no result."""

    dropped: 'Event | None' = None  # the reason, if the message was dropped
    begins: bool = False  # the stream restarted; earlier results are not continued
    state: 'State | None' = None  # measured state
    estimate: 'Estimate | None' = None  # None while the filter settles
    prediction: 'Prediction | None' = None
    external: 'External | None' = None

    def delay_of(self, result: 'Estimate | External | None') -> 'float | None':
        """Return the time from the instant of a result to the measured state [s]."""
        if self.state is None or result is None:
            return None
        return float(self.state.stamp_ns - result.stamp_ns) * 1e-9

    def efforts(self) -> 'Iterator[tuple[Prediction | External, dict[str, Array]]]':
        """Yield each result with its efforts by topic name, arrays (7,) [N m]."""
        if self.prediction is not None:
            efforts = {'predicted_effort': self.prediction.effort}
            if self.prediction.residual is not None:
                efforts['effort_residual'] = self.prediction.residual
                efforts['residual_deviation'] = self.prediction.deviation
            yield self.prediction, efforts
        if self.external is not None:
            yield self.external, {'external_effort': self.external.effort}


class Predictor:
    """
    Predicts one arm's effort from its joint states and estimates the external torque.

    The node and the evaluation of recordings share this class; it uses neither ROS nor any clock
    other than the stamps. :meth:`handle` combines :meth:`estimate`, which processes messages in
    order, with :meth:`predict`, which has no state and also accepts a batch of estimates. The
    external torque is estimated if ``external`` is true. ``counts`` adds to the counts of the
    stream 'predicted' and 'external': messages with an estimate and with an external torque.
    """

    def __init__(self, settings: PredictorSettings, external: bool = False) -> None:
        self.settings = settings
        self.stream = Stream(settings.arm, settings.stamps, settings.joint_prefix)
        self.counts = self.stream.counts
        self.model = settings.model
        self.estimator = MotionEstimator(settings)
        self.external = ExternalEffort(settings) if external else None

    def configure(self, settings: PredictorSettings) -> None:
        """Change the settings in mid-stream, from the next message on; the arm stays."""
        before, self.settings = self.settings, settings

        def changed(*names: str) -> bool:
            return any(getattr(settings, name) != getattr(before, name) for name in names)

        model = 'method', 'effort_model', 'gravity', 'base', 'payload', 'links'
        if changed(*model):
            self.model = settings.model
            self.estimator.dahl.change_length(self.model.effort_model.presliding_length)
        if changed('align', 'acceleration', 'effort_band'):
            self.estimator.configure(settings)
        if changed('stamps'):
            self.stream.reset(settings.stamps)
        if self.external is not None and changed(*model, 'external_effort', 'contact'):
            self.external.configure(settings, self.model)

    def reset(self) -> None:
        """Forget the stream and everything learned about free motion; the counts stay."""
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
            Header stamp [ns].
        names : sequence of str
            Joint names in any order; other joints are ignored.
        position, velocity, effort : ndarray
            One value per name, in rad, rad/s, N m; velocity and effort may be empty. NaN means
            "not available".
        received_ns : int, optional
            Time of receipt [ns]. It replaces zero stamps, and all stamps if the setting ``stamps``
            is 'receipt', or 'auto' and the header stamps stand still.

        """
        step = self.estimate(stamp_ns, names, position, velocity, effort, received_ns)
        if step.estimate is None:
            return step
        return step._replace(prediction=self.predict(step.estimate))

    def estimate(self, stamp_ns: int, names: Sequence[str], position: Array, velocity: Array,
                 effort: Array, received_ns: 'int | None' = None) -> Step:
        """Process a joint state, as :meth:`handle` does, without predicting its effort."""
        state = self.stream.take(stamp_ns, names, position, velocity, effort, received_ns)
        if isinstance(state, Event):
            return Step(dropped=state)
        dt, begins = state.dt, state.begins
        if dt is None:
            return Step(None, begins, state)
        if begins:
            self.estimator.reset()
            if self.external is not None:
                self.external.restart()
        motion = self.estimator.update(state.stamp_ns, dt, state.q, state.qd, state.effort)
        external = None
        if self.external is not None and (begins or dt > 0.0):
            external = self.external.update(dt, motion)
            self.counts['external'] += external is not None
        if motion.estimate is not None:
            self.counts['predicted'] += 1
        return Step(None, begins, state, motion.estimate, external=external)

    def predict(self, estimate: Estimate) -> Prediction:
        """Predict the effort of an estimate, or of a batch of estimates with leading axes."""
        stamp_ns, q, qd, qdd, measured, presliding = estimate
        model = self.model.effort_model
        tau = self.model.inverse_dynamics(q, qd, qdd)
        effort = model.effort(tau, q, qd, qdd, presliding)
        held = int(np.count_nonzero(model.spring_is_held(q)))
        if held:
            self.counts[Event.SPRING_HELD] += held
        residual = None if measured is None else measured - effort
        deviation = model.deviation_at(qd, qdd)
        for array in (tau, effort, residual, deviation):
            if array is not None:
                array.setflags(write=False)
        return Prediction(stamp_ns, q, qd, qdd, tau, effort, residual, deviation)

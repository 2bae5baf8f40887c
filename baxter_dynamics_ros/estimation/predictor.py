"""The stream handler: a joint state in, a prediction and its residual out."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from .arm_model import ArmModel
from .events import Event
from .external import ExternalEffort
from .motion_estimator import MotionEstimator
from .stream import State, Stream
from ..model.arrays import Array
from ..model.presliding import Presliding


class Estimate(NamedTuple):
    """How the arm moved at one instant, and what it measured; read-only (7,) in joint order."""

    # The instant [ns], on the clock of the joint states' stamps: int, or as many in a batch.
    stamp_ns: Any
    q: Array  # position [rad]
    qd: Array  # velocity [rad/s]
    qdd: Array  # acceleration [rad/s^2]
    measured: 'Array | None'  # effort [N m]
    presliding: Array  # Dahl's state [-]


class Prediction(NamedTuple):
    """What the arm needs at one instant, and what it measured; read-only (7,) in joint order."""

    # The instant [ns], on the clock of the joint states' stamps: int, or as many in a batch.
    stamp_ns: Any
    q: Array  # position [rad]
    qd: Array  # velocity [rad/s]
    qdd: Array  # acceleration [rad/s^2]
    tau: Array  # M(q) qdd + C(q, qd) qd + G(q) [N m]
    effort: Array  # the measured effort that tau predicts [N m]
    residual: 'Array | None'  # measured - predicted effort [N m]; None without a measurement


class Predictor:
    """
    Predict one arm's effort from its joint states, and tell what pushes it.

    The same code serves the node and recordings; it knows no ROS and no clock but the stamps.
    :meth:`handle` is :meth:`estimate`, which goes message by message, and then :meth:`predict`,
    which has no memory and takes many estimates stacked as well as one.

    Parameters
    ----------
    stream : Stream
        The door.
    model : ArmModel
        Torques, momentum and effort.
    estimator : MotionEstimator
        Velocities, accelerations and their alignment.
    external : ExternalEffort, optional
        What pushes the arm; without it that is not asked.

    Attributes
    ----------
    counts : Counter
        The stream's: how often each :class:`Event` occurred, 'received' and 'taken'; and under
        'predicted' and 'external' the messages that gave a prediction and an external effort.
    prediction : Prediction or None
        The newest prediction; None after a reset until the filter has settled.

    """

    def __init__(self, stream: Stream, model: ArmModel, estimator: MotionEstimator,
                 external: ExternalEffort | None = None) -> None:
        self.stream = stream
        self.counts = stream.counts
        self.model = model
        self.estimator = estimator
        self.external = external
        self.prediction: Prediction | None = None
        self._presliding = Presliding(model.effort_model.dahl_length)

    @property
    def latest(self) -> 'State | None':
        """Return the arm's state as last measured."""
        return self.stream.latest

    @property
    def delay(self) -> float:
        """Return how far the prediction's instant is behind the newest joint state [s]."""
        latest, prediction = self.latest, self.prediction
        if latest is None or prediction is None:
            return self.estimator.delay
        return (latest.stamp_ns - prediction.stamp_ns) * 1e-9

    @property
    def presliding(self) -> Array:
        """Return Dahl's state at the newest prediction (7,) [-]."""
        return self._presliding.z

    def configure(self, model: ArmModel) -> None:
        """Change the model in mid-stream: it holds from the next message on."""
        if not self.model.effort_model.has_dahl:
            self._presliding.reset()  # it stood still
        self.model = model
        self._presliding.length = model.effort_model.dahl_length
        if self.external is not None:
            self.external.configure(model)

    def replace_estimator(self, estimator: MotionEstimator) -> None:
        """Change the filter in mid-stream: predictions are withheld until it has settled."""
        self.estimator = estimator
        self.prediction = None

    def restart(self, stamps: str) -> None:
        """Change the mode of the stamps, which restarts the stream; the counts stay."""
        self.stream.reset(stamps)
        self._restart()

    def reset(self) -> None:
        """Forget the stream, and what free motion is like; the counts stay."""
        self.stream.reset()
        self._restart()
        if self.external is not None:
            self.external.reset()

    def handle(self, stamp_ns: int, names: Sequence[str], position: Array, velocity: Array,
               effort: Array, received_ns: 'int | None' = None) -> 'Prediction | None':
        """
        Take a joint state.

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
        Prediction or None
            For ``stamp_ns`` less the estimator's delay, or, where stamps are re-timed, the
            re-timed one less that. None for messages that are dropped, which ``counts`` tells, and
            for those that are taken while the filter settles. What pushes the arm is then in
            ``external.latest``.

        """
        estimate = self.estimate(stamp_ns, names, position, velocity, effort, received_ns)
        if estimate is None:
            return None
        self.prediction = self.predict(estimate)
        return self.prediction

    def estimate(self, stamp_ns: int, names: Sequence[str], position: Array, velocity: Array,
                 effort: Array, received_ns: 'int | None' = None) -> 'Estimate | None':
        """Take a joint state, as :meth:`handle` does, without predicting its effort."""
        sample = self.stream.take(stamp_ns, names, position, velocity, effort, received_ns)
        if self.external is not None:
            self.external.latest = None
        if sample is None:
            if self.stream.begins:  # what was predicted last is of another time line
                self.prediction = None
            return None
        if sample.begins:
            self._restart()
        state = sample.state
        motion = self.estimator.update(sample.dt, state.q, state.qd, state.effort)
        if self.external is not None:
            external = self.external.update(
                sample, self.estimator.velocity, self.estimator.velocity_lag)
            self.counts['external'] += external is not None
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
        self.prediction = None

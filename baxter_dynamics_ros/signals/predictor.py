"""The stream handler: a joint state in, a prediction and its residual out."""

from collections import Counter
from typing import NamedTuple

import numpy as np

from .continuity import Continuity
from .events import DROPPED
from .events import Event
from .events import RESETS
from .intake import Intake
from .motion import MotionEstimator
from ..core.effort import EffortModel
from ..core.presliding import Presliding


class Estimate(NamedTuple):
    """How the arm moved at one instant, and what it measured; read-only (7,) in joint order."""

    stamp_ns: int  # the instant [ns], on the clock of the joint states' stamps
    q: np.ndarray  # position [rad]
    qd: np.ndarray  # velocity [rad/s]
    qdd: np.ndarray  # acceleration [rad/s^2]
    measured: 'np.ndarray | None'  # effort [N m]
    presliding: np.ndarray  # Dahl's state [-]


class Prediction(NamedTuple):
    """What the arm needs at one instant, and what it measured; read-only (7,) in joint order."""

    stamp_ns: int  # the instant [ns], on the clock of the joint states' stamps
    q: np.ndarray  # position [rad]
    qd: np.ndarray  # velocity [rad/s]
    qdd: np.ndarray  # acceleration [rad/s^2]
    tau: np.ndarray  # M(q) qdd + C(q, qd) qd + G(q) [N m]
    effort: np.ndarray  # the measured effort that tau predicts [N m]
    residual: 'np.ndarray | None'  # measured - predicted effort [N m]; None without a measurement


class State(NamedTuple):
    """The arm's state as last measured; arrays (7,) in joint order."""

    stamp_ns: int  # [ns]
    q: np.ndarray  # [rad]
    qd: 'np.ndarray | None'  # [rad/s]
    effort: 'np.ndarray | None'  # [N m]; None where there is none, or none that is valid


class Predictor:
    """
    Predict one arm's effort from its joint states.

    The same code serves the node and recordings; it knows no ROS and no clock but the stamps.
    :meth:`handle` is :meth:`estimate`, which goes message by message, and then :meth:`predict`,
    which has no memory and takes many estimates stacked as well as one.

    Parameters
    ----------
    side : str
        'right' or 'left'.
    inverse_dynamics : callable
        tau (7,) = f(q, qd, qdd).
    effort_model : EffortModel
        From tau to measured effort.
    estimator : MotionEstimator
        Velocities, accelerations and their alignment.

    Attributes
    ----------
    counts : Counter
        How often each :class:`Event` occurred; under 'received' all messages, under 'taken' those
        that were not dropped, under 'predicted' those that gave a prediction.
    latest : State or None
        The newest measured state.
    prediction : Prediction or None
        The newest prediction; None after a reset until the filter has settled.

    """

    def __init__(self, side: str, inverse_dynamics, effort_model: EffortModel,
                 estimator: MotionEstimator):
        self.intake = Intake(side)
        self.effort_model = effort_model
        self.estimator = estimator
        self.counts = Counter()
        self.latest = None
        self.prediction = None
        self._inverse_dynamics = inverse_dynamics
        self._continuity = Continuity()
        self._presliding = Presliding(effort_model.dahl_length)

    @property
    def presliding(self) -> np.ndarray:
        """Dahl's state at the newest prediction (7,) [-]."""
        return self._presliding.z

    def configure(self, inverse_dynamics, effort_model: EffortModel, estimator=None):
        """Change the model in mid-stream; a new estimator starts anew, the counts stay."""
        self._inverse_dynamics = inverse_dynamics
        self.effort_model = effort_model
        self._presliding.length = effort_model.dahl_length
        if estimator is not None:
            self.estimator = estimator
            self.reset()

    def reset(self):
        """Forget the stream; the counts stay."""
        self.counts[Event.RESET_REQUESTED] += 1
        self._continuity.forget()
        self._restart()

    def handle(self, stamp_ns: int, names, position, velocity, effort) -> 'Prediction | None':
        """
        Take a joint state.

        Parameters
        ----------
        stamp_ns : int
            Its stamp [ns].
        names : sequence of str
            Its joints, in any order, other joints among them.
        position, velocity, effort : ndarray
            As long as names, in rad, rad/s, N m; velocity and effort may be empty.

        Returns
        -------
        Prediction or None
            For ``stamp_ns`` less the estimator's delay. None for messages that are dropped, which
            ``counts`` tells, and for those that are taken while the filter settles.

        """
        estimate = self.estimate(stamp_ns, names, position, velocity, effort)
        if estimate is None:
            return None
        self.prediction = self.predict(estimate)
        return self.prediction

    def estimate(self, stamp_ns: int, names, position, velocity, effort) -> 'Estimate | None':
        """Take a joint state, as :meth:`handle` does, without predicting its effort."""
        self.counts['received'] += 1
        reading = self.intake.read(names, position, velocity, effort)
        if isinstance(reading, Event):
            self.counts[reading] += 1
            return None
        q, qd, measured = reading
        verdict = self._continuity.judge(stamp_ns, q, qd, measured)
        if verdict is not None:
            self.counts[verdict] += 1
            if verdict in DROPPED:
                return None
            if verdict in RESETS:
                self._restart()
        self.counts['taken'] += 1
        dt = 0.0 if self.latest is None else (stamp_ns - self.latest.stamp_ns) * 1e-9
        measured = self._valid(measured)
        self.latest = State(stamp_ns, q, qd, measured)
        motion = self.estimator.update(dt, q, qd, measured)
        if qd is None:
            self.counts[Event.VELOCITY_MISSING] += 1
        if motion is None:
            return None
        self.counts['predicted'] += 1
        if self.effort_model.has_dahl:
            self._presliding.update(motion.q)
        return Estimate(stamp_ns - round(motion.delay * 1e9), *motion[1:], self._presliding.z)

    def predict(self, estimate: Estimate) -> Prediction:
        """
        Predict the effort of an estimate.

        Parameters
        ----------
        estimate : Estimate
            Its arrays may have leading axes: a batch.

        """
        stamp_ns, q, qd, qdd, measured, presliding = estimate
        tau = self._inverse_dynamics(q, qd, qdd)
        effort = self.effort_model.effort(tau, q, qd, qdd, presliding)
        held = np.count_nonzero(self.effort_model.spring_is_held(q))
        if held:
            self.counts[Event.SPRING_HELD] += held
        residual = None
        if measured is not None:
            residual = measured - effort
            residual.setflags(write=False)
        for array in (q, qd, qdd, tau, effort):
            array.setflags(write=False)
        return Prediction(stamp_ns, q, qd, qdd, tau, effort, residual)

    def _valid(self, effort):
        """Return the measured effort, or None where the robot cannot have measured it."""
        if effort is None:
            self.counts[Event.EFFORT_MISSING] += 1
        elif not any(effort.tolist()):
            self.counts[Event.EFFORT_ALL_ZERO] += 1
            return None
        return effort

    def _restart(self):
        self.estimator.reset()
        self._presliding.reset()
        self.prediction = None

"""
External joint torque without accelerations, contact, and the wrench at the hand.

For ``M qdd + C qd + G = tau + tau_ext`` the momentum p = M qd obeys ``dp/dt = tau + C^T qd - G +
tau_ext``. The observer integrates the known terms; the difference from p reveals tau_ext.
"""

from dataclasses import replace
from math import log, sqrt
from typing import NamedTuple

import numpy as np

from .contact import ContactDetector
from .continuity import GAP
from .motion_estimator import MotionUpdate
from .settings import ArmModel, ContactSettings, PredictorSettings
from ..model import Array, Bools, N_JOINTS, Presliding

LOWEST_RATE = 15.0  # sample rate below which contact is not reported [Hz]
_RATE_TIME = 1.0  # averaging time of the sample rate [s]
_RANGE = 3.5  # largest model error, in expected standard deviations of the residual at 1 rad/s

# Length that scales torques to forces: about the distance from the wrist to the hand frame [m].
LEVER = 0.25
# Smallest singular value of the scaled Jacobian for which a wrench is returned [m].
LEAST_SINGULAR_VALUE = 0.02
_SCALE = np.array([1.0, 1.0, 1.0, LEVER, LEVER, LEVER])


class External(NamedTuple):
    """External torque at one instant; read-only arrays (7,) in joint order."""

    stamp_ns: int  # the instant [ns], on the clock of the joint states' stamps
    q: Array  # position [rad]
    qd: Array  # velocity [rad/s]
    effort: Array  # external torque tau_ext [N m], positive in the direction of positive q
    contact: 'bool | None'  # None while unknown, see :class:`ExternalEffort`
    joints: Bools  # joints that show the contact


class HandWrench(NamedTuple):
    """External wrench on the hand; read-only arrays (3,), base axes."""

    force: Array  # [N]
    torque: Array  # about the origin of the hand frame [N m]
    unexplained: float  # norm of the external torque that no hand wrench explains [N m]


class ExternalEffort:
    """
    Estimates tau_ext, and whether the arm is in contact.

    tau is the measured effort minus the terms of the effort model, except for the added inertia,
    which is part of the momentum. Contact is unknown while the observer settles and below
    :data:`LOWEST_RATE` samples per second.
    """

    def __init__(self, settings: PredictorSettings) -> None:
        self._observer = MomentumObserver(settings.external_effort.gain)
        self.detector = ContactDetector(contact_settings(settings), self._observer.settling_time)
        self._model = settings.model
        self._dahl = Presliding(self._model.effort_model.presliding_length)
        self._rate = 0.0  # sample rate [Hz]; zero while unknown
        # Time since the stream began [s], q, qd and measured effort of the newest estimate.
        self._last: tuple[float, Array, Array, Array] | None = None

    @property
    def is_too_slow(self) -> bool:
        """Whether the sample rate is too low to detect contact."""
        return 0.0 < self._rate < LOWEST_RATE

    def reset(self) -> None:
        """Forget the stream and everything learned about free motion."""
        self.restart()
        self.detector.reset()

    def restart(self) -> None:
        """Start a new stream: the observer settles again."""
        self._last = None
        self._dahl.reset()
        self.detector.restart()

    def configure(self, settings: PredictorSettings, model: ArmModel) -> None:
        """Change the settings in mid-stream; external torque and bias step with the model."""
        self._observer.gain = settings.external_effort.gain
        self.detector.settling = self._observer.settling_time
        self.detector.configure(contact_settings(settings))
        before, self._model = self._model, model
        self._dahl.change_length(model.effort_model.presliding_length)
        if self._last is not None:
            (old_momentum, old_rate), (momentum, rate) = (
                self._balance(each, *self._last[1:]) for each in (before, model))
            self._observer.rebase(momentum - old_momentum, old_rate - rate)
            self.detector.rebase(old_rate - rate)

    def update(self, dt: float, motion: MotionUpdate) -> 'External | None':
        """
        Process the next sample, dt [s] after the last one; dt is zero for the first.

        Returns the external torque at the instant of the velocity; None without measured effort,
        or if the stream began after that instant.
        """
        if dt > 0.0:
            self._rate += (1.0 - self._rate * dt) / (dt + _RATE_TIME if self._rate else dt)
        stamp_ns, t, q, qd, measured, _ = motion
        if self._last is not None and t - self._last[0] > GAP:
            self._last = None
            self.detector.restart()
        if q is None or measured is None:
            return None
        self._dahl.update(q)
        if self._last is None:
            self._observer.reset()
        before = t if self._last is None else self._last[0]
        effort = self._observer.update(
            max(t - before, 0.0), *self._balance(self._model, q, qd, measured))
        self._last = t, q, qd, measured
        contact = self.detector.update(dt, effort, q)
        known = not self.detector.is_settling and not self.is_too_slow
        joints = self.detector.joints if known and contact else np.zeros(N_JOINTS, dtype=bool)
        for array in (q, qd, effort, joints):
            array.setflags(write=False)
        return External(stamp_ns, q, qd, effort, contact if known else None, joints)

    def _balance(self, model: ArmModel, q: Array, qd: Array,
                 measured: Array) -> tuple[Array, Array]:
        """Return the momentum [N m s] and its rate without external torque [N m], (7,) each."""
        momentum, coriolis, gravity = model.arm.momentum_terms(q, qd)
        torque = model.effort_model.torque(measured, q, qd, self._dahl.z)
        # The effort of the added inertia is the time derivative of its momentum.
        return momentum + model.effort_model.added_inertia * qd, torque + coriolis - gravity


class MomentumObserver:
    """
    Estimates tau_ext by ``r = K (p - integral(rate + r) dt - p(0))``: r' = K (tau_ext - r).

    Integrated by the backward Euler method with the true time steps: stable for any step.
    """

    def __init__(self, gain: float) -> None:
        # K [1/s]: r follows tau_ext like a first-order low-pass with the time constant 1 / K.
        self.gain = gain
        self.reset()

    @property
    def settling_time(self) -> float:
        """Time in which the initial error decays to 1 % [s]."""
        return log(100.0) / self.gain

    def reset(self) -> None:
        """Forget all samples; r is zero at the next one."""
        self._momentum: Array = np.zeros(0)  # at the last sample [N m s]
        self.r: Array | None = None  # newest estimate of tau_ext (7,) [N m]

    def rebase(self, momentum: Array, r: Array) -> None:
        """Add (7,) [N m s] to the last momentum and (7,) [N m] to r, as when the model changes."""
        if self.r is not None:
            self._momentum = self._momentum + momentum
            self.r = self.r + r

    def update(self, dt: float, momentum: Array, rate: Array) -> Array:
        """
        Process the next sample and return r (7,) [N m].

        momentum is p (7,) [N m s], rate is dp/dt without external torque, tau + C^T qd - G (7,)
        [N m], and dt is the time since the last sample [s], which may be zero.
        """
        if self.r is None:
            self.r = np.zeros(len(momentum))
        else:
            # r = K (p - p_hat) and p_hat = p_hat_last + (rate + r) dt, where p_hat = p - r / K
            gain = self.gain
            unexplained = momentum - self._momentum - dt * rate  # [N m s]
            self.r = (self.r + gain * unexplained) * (1.0 / (1.0 + gain * dt))
        self._momentum = momentum
        return self.r


def contact_settings(settings: PredictorSettings) -> ContactSettings:
    """
    Return the settings of contact with the model errors that the robot is expected to have.

    ``contact.limit`` holds for an uncalibrated robot. The expected deviation of a calibrated one
    is smaller, so a weaker contact is reported for as long as it lasts.
    """
    contact, model = settings.contact, settings.model.effort_model
    expected = _RANGE * model.deviation_at(np.ones(N_JOINTS), np.zeros(N_JOINTS))
    limit = np.clip(np.where(expected > 0.0, expected, np.inf), contact.floor, contact.limit)
    return replace(contact, limit=tuple(limit.tolist()))


def hand_wrench(jacobian: Array, external: Array) -> 'HandWrench | None':
    """
    Return the wrench w with J^T w = r, by least squares, for J (6, 7) and r (7,) [N m].

    Near a singularity some wrenches cause almost no joint torque. None is returned where errors of
    0.1 N m per joint (standard deviation) in r could cause an error above 5 N, or 1.25 N m, in
    some direction: in 18 % of random postures within the limits, two thirds of them with the elbow
    nearly straight (e1 below 0.3 rad), and nowhere on the paper's three trajectories, where the
    error is at most 0.6 N and 0.3 N m.

    ``unexplained`` is the component of r along the arm's self-motion, in which the hand does not
    move. It is zero for a push on the hand, and nonzero for a push on the elbow in the direction
    in which the elbow can swing.
    """
    scaled = jacobian * _SCALE[:, None]
    squares, directions = np.linalg.eigh(scaled.dot(scaled.T))
    if squares[0] < LEAST_SINGULAR_VALUE ** 2:
        return None
    wrench = directions.dot(scaled.dot(external).dot(directions) / squares) * _SCALE
    wrench.setflags(write=False)
    rest = external - wrench.dot(jacobian)
    return HandWrench(wrench[:3], wrench[3:], sqrt(rest.dot(rest)))

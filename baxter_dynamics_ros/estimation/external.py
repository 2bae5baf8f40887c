"""External joint torque, contact, and the wrench at the hand."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .arm_model import ArmModel
from .contact import ContactDetector
from .continuity import GAP
from .motion_estimator import MotionEstimate
from .observer import MomentumObserver
from .settings import ContactSettings, PredictorSettings
from .wrench import hand_wrench, HandWrench
from ..model.arrays import Array, Bools
from ..model.effort import Presliding
from ..model.joints import N_JOINTS

LOWEST_RATE = 15.0  # sample rate below which contact is not reported [Hz]
_RATE_TIME = 1.0  # averaging time of the sample rate [s]
_RANGE = 3.5  # largest model error, in expected standard deviations of the residual
_VELOCITY = np.ones(N_JOINTS)  # at which it is expected [rad/s]
_NO_JOINTS = np.zeros(N_JOINTS, dtype=bool)


class External(NamedTuple):
    """External torque at one instant; read-only arrays (7,) in joint order."""

    stamp_ns: int  # the instant [ns], on the clock of the joint states' stamps
    q: Array  # position [rad]
    qd: Array  # velocity [rad/s]
    effort: Array  # external torque tau_ext [N m], positive in the direction of positive q
    contact: 'bool | None'  # None while unknown, see :class:`ExternalEffort`
    joints: Bools  # joints that show the contact


class ExternalEffort:
    r"""
    Estimates tau_ext of ``M qdd + C qd + G = tau + tau_ext`` without accelerations.

    tau is the measured effort minus the terms of the effort model, except for the added inertia,
    which is part of the momentum. Contact is unknown while the observer settles and below
    :data:`LOWEST_RATE` samples per second.

    Attributes
    ----------
    detector : ContactDetector
        Contact detector.

    """

    def __init__(self, settings: PredictorSettings) -> None:
        self._observer = MomentumObserver(settings.external_effort.gain)
        self.detector = ContactDetector(contact_settings(settings),
                                        self._observer.settling_time)
        self._model = settings.model
        self._presliding = Presliding(self._model.effort_model.dahl_length)
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
        self._presliding.reset()
        self.detector.restart()

    def configure(self, settings: PredictorSettings) -> None:
        """Change observer and detector in mid-stream."""
        self._observer.gain = settings.external_effort.gain
        self.detector.configure(contact_settings(settings), self._observer.settling_time)

    def change_model(self, model: ArmModel) -> None:
        """Change the model in mid-stream; the external torque and its bias step accordingly."""
        before, self._model = self._model, model
        if not before.effort_model.has_dahl:
            self._presliding.reset()  # its state was not updated
        self._presliding.length = model.effort_model.dahl_length
        if self._last is not None:
            (old_momentum, old_rate), (momentum, rate) = (
                self._balance(each, *self._last[1:]) for each in (before, model))
            self._observer.rebase(momentum - old_momentum, old_rate - rate)
            self.detector.rebase(old_rate - rate)

    def update(self, stamp_ns: int, dt: float, motion: MotionEstimate) -> 'External | None':
        """
        Process the next sample.

        Parameters
        ----------
        stamp_ns : int
            Stamp of the sample [ns].
        dt : float
            Time since the last sample [s]; zero for the first.
        motion : MotionEstimate
            Motion at the instant of its velocity.

        Returns
        -------
        External or None
            External torque at the instant of the velocity. None without measured effort, or if the
            stream began after that instant.

        """
        if dt > 0.0:
            self._rate += (1.0 - self._rate * dt) / (dt + _RATE_TIME if self._rate else dt)
        t, lag, q, qd, measured, _ = motion
        if self._last is not None and t - self._last[0] > GAP:
            self._last = None
            self.detector.restart()
        if q is None or measured is None:
            return None
        if self._model.effort_model.has_dahl:
            self._presliding.update(q)
        if self._last is None:
            self._observer.reset()
        before = t if self._last is None else self._last[0]
        effort = self._observer.update(
            max(t - before, 0.0), *self._balance(self._model, q, qd, measured))
        self._last = t, q, qd, measured
        contact = self.detector.update(dt, effort, q)
        known = not self.detector.is_settling and not self.is_too_slow
        for array in (q, qd, effort):
            array.setflags(write=False)
        return External(stamp_ns - round(lag * 1e9), q, qd, effort, contact if known else None,
                        self.detector.joints if known and contact else _NO_JOINTS)

    def wrench(self, external: External) -> 'HandWrench | None':
        """Return the hand wrench that best explains tau_ext, or None near a singularity."""
        return hand_wrench(self._model.arm.jacobian(external.q), external.effort)

    def _balance(self, model: ArmModel, q: Array, qd: Array,
                 measured: Array) -> tuple[Array, Array]:
        """Return the momentum [N m s] and its rate without external torque [N m], (7,) each."""
        effort = model.effort_model
        presliding = self._presliding.z if effort.has_dahl else None
        momentum, coriolis, gravity = model.momentum_terms(q, qd)
        return momentum, effort.torque(measured, q, qd, presliding) + coriolis - gravity


def contact_settings(settings: PredictorSettings) -> ContactSettings:
    """
    Return the settings of contact with the model errors that the robot is expected to have.

    ``contact.limit`` holds for an uncalibrated robot. The expected deviation of a calibrated one
    is smaller, so a weaker contact is reported for as long as it lasts.
    """
    expected = _RANGE * settings.model.effort_model.deviation_at(_VELOCITY, np.zeros(N_JOINTS))
    limit = np.where(expected > 0.0, np.minimum(settings.contact.limit, expected),
                     settings.contact.limit)
    return replace(settings.contact, limit=tuple(
        np.maximum(limit, settings.contact.floor).tolist()))

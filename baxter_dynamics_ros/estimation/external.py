"""What pushes the arm: the external joint torque, whether that is contact, and the wrench."""

from typing import Any, NamedTuple

import numpy as np

from .arm_model import ArmModel
from .contact import ContactDetector
from .continuity import GAP
from .delay_line import DelayLine
from .observer import MomentumObserver
from .stream import Sample
from .wrench import hand_wrench, HandWrench
from ..model.arrays import Array
from ..model.joints import N_JOINTS
from ..model.presliding import Presliding

LOWEST_RATE = 15.0  # of samples, below which contact is not reported [Hz]
_RATE_TIME = 1.0  # over which the rate is averaged [s]
_ZERO = np.zeros(N_JOINTS)


class External(NamedTuple):
    """What pushes the arm at one instant; read-only arrays (7,) in joint order."""

    stamp_ns: int  # the instant [ns], on the clock of the joint states' stamps
    q: Array  # position [rad]
    qd: Array  # velocity [rad/s]
    effort: Array  # external torque tau_ext [N m], in the direction of positive q
    contact: 'bool | None'  # None while it is unknown


class ExternalEffort:
    r"""
    Estimates tau_ext of ``M qdd + C qd + G = tau + tau_ext`` without accelerations.

    Position and effort are looked up as much earlier as the velocity lags (14 ms), so that all
    belong to one instant. tau is the measured effort less what the effort model says it has
    beyond torque; added inertia moves with its joint, so its momentum joins the links'.

    Parameters
    ----------
    model : ArmModel
        The arm's momentum, its hand, and its effort.
    gain : float
        The :class:`MomentumObserver`'s [1/s].
    **contact
        The :class:`ContactDetector`'s settings.

    Attributes
    ----------
    detector : ContactDetector
        Says what of it is contact.
    latest : External or None
        The newest estimate; None where the newest sample gave none.

    """

    def __init__(self, model: ArmModel, gain: float, **contact: Any) -> None:
        self._observer = MomentumObserver(gain)
        self.detector = ContactDetector(settling=self._observer.settling_time, **contact)
        self.latest: External | None = None
        self._model = model
        self._history = DelayLine()
        self._presliding = Presliding(model.effort_model.dahl_length)
        self._rate = 0.0  # of the samples [Hz]; zero while unknown
        self._t = 0.0  # of the newest sample, since the stream's beginning [s]
        # Time of the newest estimate on the same clock [s], and its q, qd and measured effort.
        self._then: float | None = None
        self._state: tuple[Array, Array, Array] | None = None

    def reset(self) -> None:
        """Forget the stream, and what free motion is like."""
        self._restart()
        self.detector.reset()

    def configure(self, model: ArmModel) -> None:
        """Change the model in mid-stream: the external torque and its bias step to the new one."""
        before, self._model = self._model, model
        if not before.effort_model.has_dahl:
            self._presliding.reset()  # it stood still
        self._presliding.length = model.effort_model.dahl_length
        if self._state is not None:
            (old_momentum, old_rate), (momentum, rate) = (
                self._balance(each, *self._state) for each in (before, model))
            self._observer.rebase(momentum - old_momentum, old_rate - rate)
            self.detector.rebase(old_rate - rate)

    def tune(self, gain: float, **contact: Any) -> None:
        """Change the observer's gain and the detector's settings in mid-stream."""
        self._observer.gain = gain
        self.detector.configure(settling=self._observer.settling_time, **contact)

    def update(self, sample: Sample, qd: Array, lag: float) -> 'External | None':
        """
        Take the next sample.

        Parameters
        ----------
        sample : Sample
            Of the stream.
        qd : ndarray (7,)
            Its velocity, measured or not [rad/s].
        lag : float
            How far that lags the position [s].

        Returns
        -------
        External or None
            For ``lag`` before the sample. None without measured effort, where the stream began
            less than ``lag`` ago, and where the sample takes the last one's place.

        """
        state = sample.state
        if sample.begins:
            self._restart()
        else:
            self._t += sample.dt
            self._count(sample.dt)
        self._history.append(self._t, state.q, state.effort)
        self.latest = None
        if sample.dt == 0.0 and not sample.begins:
            return None
        now = self._history.at(self._t - lag)
        then = self._t - lag
        if self._then is not None and then - self._then > GAP:
            self._then = self._state = None
            self.detector.restart()
        if now is None or now[1] is None:
            return None
        q, measured = now[0], now[1]
        if self._model.effort_model.has_dahl:
            self._presliding.update(q)
        momentum, rate = self._balance(self._model, q, qd, measured)
        if self._then is None:
            self._observer.reset()
            self._then = then
        effort = self._observer.update(max(then - self._then, 0.0), momentum, rate)
        self._then, self._state = then, (q, qd, measured)
        contact = self.detector.update(sample.dt, effort, q)
        known = not self.detector.is_settling and not self.is_too_slow
        for array in (q, qd, effort):
            array.setflags(write=False)
        self.latest = External(state.stamp_ns - round(lag * 1e9), q, qd, effort, contact if known else None)
        return self.latest

    @property
    def is_too_slow(self) -> bool:
        """Whether samples are too far apart to detect contact."""
        return 0.0 < self._rate < LOWEST_RATE

    def wrench(self, external: External) -> 'HandWrench | None':
        """Return the wrench at the hand that explains tau_ext best, or None near singularities."""
        return hand_wrench(self._model.jacobian(external.q), external.effort)

    def _balance(self, model: ArmModel, q: Array, qd: Array,
                 measured: Array) -> tuple[Array, Array]:
        """Return the momentum [N m s] and its rate without external torque [N m], (7,) each."""
        effort = model.effort_model
        presliding = self._presliding.z if effort.has_dahl else None
        tau = measured - effort.effort(_ZERO, q, qd, _ZERO, presliding)
        momentum, coriolis, gravity = model.momentum_terms(q, qd)
        return momentum, tau + coriolis - gravity

    def _count(self, dt: float) -> None:
        """Average the rate of the samples."""
        self._rate += (1.0 - self._rate * dt) / (dt + _RATE_TIME if self._rate else dt or np.inf)

    def _restart(self) -> None:
        self._t = 0.0
        self._then = self._state = None
        self.latest = None
        self._history.reset()
        self._presliding.reset()
        self.detector.restart()

"""What pushes the arm: the external joint torque, whether that is contact, and the wrench."""

from typing import Any, NamedTuple

import numpy as np

from .arm_model import ArmModel
from .contact import ContactDetector
from .delay_line import DelayLine
from .observer import MomentumObserver
from .stream import Sample
from .wrench import hand_wrench, HandWrench
from ..model.arrays import Array
from ..model.joints import N_JOINTS
from ..model.presliding import Presliding

_ZERO = np.zeros(N_JOINTS)


class External(NamedTuple):
    """What pushes the arm at one instant; read-only arrays (7,) in joint order."""

    stamp_ns: int  # the instant [ns], on the clock of the joint states' stamps
    q: Array  # position [rad]
    qd: Array  # velocity [rad/s]
    effort: Array  # external torque tau_ext [N m], in the direction of positive q
    contact: bool  # whether something beyond the model pushes


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
        self._gain: float | None = None
        self.tune(gain, **contact)
        self.latest: External | None = None
        self._model = model
        self._history = DelayLine()
        self._presliding = Presliding(model.effort_model.dahl_length)
        self._t = 0.0  # of the newest sample, since the stream's beginning [s]
        # When the newest estimate is for, on the same clock [s], and q and qd of that.
        self._then: float | None = None
        self._state: tuple[Array, Array] | None = None

    def reset(self) -> None:
        """Forget the stream, and what free motion is like."""
        self._restart()
        self.detector.reset()

    def configure(self, model: ArmModel) -> None:
        """
        Change the model in mid-stream.

        tau_ext goes on from where it is, towards what the new model makes it; what free motion is
        like is learnt anew.
        """
        if self._state is not None:
            self._observer.rebase(model.momentum_terms(*self._state)[0]
                                  - self._model.momentum_terms(*self._state)[0])
        if not self._model.effort_model.has_dahl:
            self._presliding.reset()  # it stood still
        self._model = model
        self._presliding.length = model.effort_model.dahl_length
        self.detector.reset()

    def tune(self, gain: float, **contact: Any) -> None:
        """Change the detector, which learns anew, and the observer, where its gain changes."""
        if gain != self._gain:
            self._gain, self._observer, self._then = gain, MomentumObserver(gain), None
        self.detector = ContactDetector(settling=self._observer.settling_time, **contact)

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
        self._history.append(self._t, state.q, state.effort)
        self.latest = None
        if sample.dt == 0.0 and not sample.begins:
            return None
        now = self._history.at(self._t - lag)
        if now is None or now[1] is None:
            if self._then is not None:
                self._then = self._state = None
                self.detector.restart()
            return None
        q, measured = now[0], now[1]
        model = self._model.effort_model
        presliding = self._presliding.update(q) if model.has_dahl else None
        tau = measured - model.effort(_ZERO, q, qd, _ZERO, presliding)
        momentum, coriolis, gravity = self._model.momentum_terms(q, qd)
        then = self._t - lag
        if self._then is None:
            self._observer.reset()
            self._then = then
        effort = self._observer.update(then - self._then, momentum, tau + coriolis - gravity)
        self._then, self._state = then, (q, qd)
        contact = self.detector.update(sample.dt, effort, q)
        for array in (q, qd, effort):
            array.setflags(write=False)
        self.latest = External(state.stamp_ns - round(lag * 1e9), q, qd, effort, contact)
        return self.latest

    def wrench(self, external: External) -> 'HandWrench | None':
        """Return the wrench at the hand that explains tau_ext best, or None near singularities."""
        return hand_wrench(self._model.jacobian(external.q), external.effort)

    def _restart(self) -> None:
        self._t = 0.0
        self._then = self._state = None
        self.latest = None
        self._history.reset()
        self._presliding.reset()
        self.detector.restart()

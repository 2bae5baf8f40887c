"""
Contact detector with an adaptive threshold.

The bias tracks the external torque of free motion within 0.15 s; sigma is the RMS deviation from
it over 30 s of free motion. Neither is updated during contact or while contact is suspected.
Contact begins when a joint deviates from its bias by more than its threshold, the larger of a
floor and k sigma, and ends when all joints have returned. The bias was learned before the contact
and loses its weight within 2.5 s as the arm moves on: from then on the external torque itself
must exceed the limit, the largest expected model error, or the contact is attributed to the model.
"""

import numpy as np

from .settings import ContactSettings
from ..model import Array, Bools, Indices, N_JOINTS

# The robot averages its velocity over 6 ms, so samples closer than this are not independent.
_SPAN = 0.008  # [s]
_FAR = 1.25  # multiple of the threshold for which one sample is enough instead of two
_BIAS_TIME = 0.15  # time constant of the bias [s]
_PRIOR = 2.0  # initial threshold as a multiple of the floor, if within the limit
_PRIOR_TIME = 1.0  # weight of the initial sigma, as a duration of free motion [s]
_RELEASE = 0.05  # time for which all joints must have returned before contact ends [s]
_FADING = 2.5  # time in which the bias loses its weight during contact [s]
_MOVED = 0.05  # motion during contact that can reveal new model errors [rad]
_EXPLAINED = 0.3  # time for which model error must explain a contact before it is dropped [s]


class ContactDetector:
    """
    Detects contact in the external torque, with thresholds learned from free motion.

    The samples above the threshold must span 8 ms. If two are required and they are further apart
    than that, one above 1.25 thresholds is enough.
    """

    def __init__(self, settings: ContactSettings, settling: float) -> None:
        self.settling = settling  # of the observer: nothing is learned for this time [s]
        self._variance: Array = np.zeros(N_JOINTS)  # of the deviation from the bias [N^2 m^2]
        self.configure(settings)
        self.reset()

    def configure(self, settings: ContactSettings) -> None:
        """Change the settings; contact and everything learned stay."""
        self.settings = settings
        self._floor = np.array(settings.floor)
        self._limit = np.maximum(settings.floor, settings.limit)
        self._update_threshold()

    def reset(self) -> None:
        """Forget everything learned."""
        self._variance = (_PRIOR * self._floor / self.settings.sigmas) ** 2
        self._update_threshold()
        self._learnt = 0.0  # duration of the free motion that sigma covers [s]
        self.in_contact = False
        self.restart()

    def restart(self) -> None:
        """Start a new stream: settle again, keep sigma and a contact."""
        self._to_settle = self.settling  # [s]
        self.is_settling = True  # whether contact is unknown
        if not self.in_contact:
            self.bias: Array = np.zeros(N_JOINTS)  # external torque of free motion [N m]
            self._has_bias = False
            self._followed = 0.0  # duration of the free motion that the bias covers [s]
            self._end()

    def _end(self) -> None:
        self.in_contact = False
        self.duration = 0.0  # of the contact [s]
        # Joints that show the contact: those that have not returned, or the last to return.
        self.joints: Bools = np.zeros(N_JOINTS, dtype=bool)
        self._count: Indices = np.zeros(N_JOINTS, dtype=int)  # consecutive samples above
        self._span: Array = np.zeros(N_JOINTS)  # time from the first to the last of them [s]
        self._start_q: Array = np.zeros(N_JOINTS)  # position at which contact began [rad]
        self._moved = False  # whether the arm has moved since
        self._back = 0.0  # time for which all joints have returned [s]
        self._explained = 0.0  # time for which model error has explained the contact [s]

    def rebase(self, change: Array) -> None:
        """
        Account for a step (7,) [N m] of the external torque caused by a change of the model.

        In free motion the bias steps as well. In contact it does not, so that adding a load to
        the model ends the contact caused by it.
        """
        if self._has_bias and not self.in_contact:
            self.bias = self._limited(self.bias + change)

    @property
    def has_learnt(self) -> bool:
        """Whether sigma covers as much free motion as its memory."""
        return self._learnt >= self.settings.memory

    @property
    def sigma(self) -> Array:
        """RMS deviation from the bias in free motion, (7,) [N m]."""
        return np.sqrt(self._variance)

    def update(self, dt: float, r: Array, q: Array) -> bool:
        """
        Process external torque r [N m] and position q [rad], (7,); return whether in contact.

        dt is the time since the last sample [s]; a sample with zero is ignored.
        """
        if self._to_settle > 0.0:
            self._to_settle -= dt
        elif dt > 0.0:
            if not self._has_bias:  # attribute what is within the model error to free motion
                self.bias = np.where(np.abs(r) <= self._limit, r, 0.0)
                self._has_bias = True
            deviation = np.abs(r - self.bias)
            above = deviation > self.threshold
            if self.in_contact:
                self._moved = self._moved or bool((np.abs(q - self._start_q) > _MOVED).any())
                self._continue(dt, r, deviation)
            elif np.count_nonzero(above):
                self._count_above(dt, deviation, above)
                self._start_q = q
            else:
                self._count.fill(0)
                self._learn(dt, r)
            if self.is_settling:  # until the first samples are contact or free motion
                self.is_settling = not self.in_contact and bool(self._count.any())
        return self.in_contact

    def _learn(self, dt: float, r: Array) -> None:
        """Update bias and sigma with a sample of free motion."""
        fast = dt / (dt + min(self._followed, _BIAS_TIME))
        slow = dt / (dt + min(self._learnt + _PRIOR_TIME, self.settings.memory))
        self._followed += dt
        self._learnt += dt
        deviation = r - self.bias
        share = deviation / self.threshold
        self.bias = self._limited(self.bias + fast * deviation * (1.0 - share * share))
        self._variance = self._variance + slow * (deviation * deviation - self._variance)
        self._update_threshold()

    def _update_threshold(self) -> None:
        self.threshold: Array = np.minimum(  # (7,), as a deviation from the bias [N m]
            np.maximum(self.settings.sigmas * self.sigma, self._floor), self._limit)

    def _limited(self, r: Array) -> Array:
        return np.minimum(np.maximum(r, -self._limit), self._limit)

    def _count_above(self, dt: float, deviation: Array, above: Bools) -> None:
        """Begin contact if enough consecutive samples are above the threshold."""
        samples = self.settings.samples
        self._span = np.where(self._count > 0, self._span + dt, 0.0)
        self._count = np.where(above, self._count + 1, 0)
        enough = (self._count >= samples) & ((self._span >= _SPAN) | (samples == 1))
        is_far = samples <= 2 and dt >= _SPAN and (deviation > _FAR * self.threshold).any()
        if is_far or enough.any():
            self.in_contact = True
            self.joints = above

    def _continue(self, dt: float, r: Array, deviation: Array) -> None:
        """Continue the contact, or end it."""
        self.duration += dt
        release = self.settings.hysteresis * self.threshold
        joints = deviation > release
        is_back = not joints.any()
        if not is_back:
            self.joints = joints
        self._back = self._back + dt if is_back else 0.0
        # The reference fades from the bias to zero, and the tolerated model error grows.
        faded = min(self.duration / _FADING, 1.0)
        tolerance = release + faded * (self._limit - release)
        is_explained = not (np.abs(r - (1.0 - faded) * self.bias) > tolerance).any()
        self._explained = self._explained + dt if is_explained else 0.0
        if self._back >= _RELEASE:
            self._end()
        elif self._explained >= _EXPLAINED:
            self._attribute_to_model(r, deviation, joints)
            self._end()

    def _attribute_to_model(self, r: Array, deviation: Array, joints: Bools) -> None:
        """Adopt the model error of some joints as bias, and after motion as threshold."""
        self.bias = np.where(joints, self._limited(r), self.bias)
        if self._moved:  # at rest a steady push causes the same, and model errors do not grow
            error = np.where(joints, np.minimum(deviation, self._limit), 0.0)
            self.threshold = np.maximum(self.threshold, error)
            self._variance = np.maximum(
                self._variance, joints * (self.threshold / self.settings.sigmas) ** 2)

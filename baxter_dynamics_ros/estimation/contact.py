"""
Contact detector with an adaptive threshold.

The bias tracks the external torque of free motion within 0.15 s; sigma is the RMS deviation from
it over 30 s of free motion. Neither is updated during contact or while contact is suspected.
Contact begins when a joint deviates from its bias by more than its threshold, the larger of a
floor and k sigma, and ends when all joints have returned. The bias was learned before the contact
and loses its weight within 2.5 s as the arm moves on: from then on the external torque itself
must exceed the error of an uncalibrated model, or the contact is attributed to the model.
"""

from math import sqrt

import numpy as np

from .settings import ContactSettings
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS

# The robot averages its velocity over 6 ms, so samples closer than this are not independent.
_SPAN = 0.008  # [s]
_FAR = 1.25  # multiple of the threshold for which one sample _SPAN after the last is enough
_BIAS_TIME = 0.15  # time constant of the bias [s]
_PRIOR = 2.0  # initial threshold, as a multiple of the floor
_PRIOR_TIME = 1.0  # weight of the initial sigma, as a duration of free motion [s]
_RELEASE = 0.05  # time for which all joints must have returned before contact ends [s]
_FADING = 2.5  # time in which the bias loses its weight during contact [s]
_MOVED = 0.05  # motion during contact that can reveal new model errors [rad]
_EXPLAINED = 0.3  # time for which model error must explain a contact before it is dropped [s]


class ContactDetector:
    """
    Detects contact in the external torque, with thresholds learned from free motion.

    Parameters
    ----------
    settings : ContactSettings
        Thresholds: floor, k ('sigmas') and limit, the upper bound of bias and k sigma. The
        'samples' above the threshold must span 8 ms; where samples are further apart than that,
        one above 1.25 thresholds is enough.
    settling : float
        Settling time of the observer after a reset or restart [s]: no detection, no learning.

    Attributes
    ----------
    in_contact : bool
        Whether the arm is in contact.

    """

    in_contact: bool
    _has_bias: bool
    _is_suspected: bool  # contact: some joint is above its threshold
    _moved: bool  # whether the arm has moved since contact began
    _start_q: Array  # position at which contact began (7,) [rad]
    _joints: list[bool]
    _count: list[int]  # consecutive samples above the threshold
    _span: list[float]  # time from the first to the last of them [s]
    _age: float  # duration of the contact [s]
    _back: float  # time for which all joints have returned [s]
    _explained: float  # time for which model error has explained the contact [s]

    def __init__(self, settings: ContactSettings, settling: float) -> None:
        self._variance: list[float] = []  # of the deviation from the bias in free motion [N^2 m^2]
        self.configure(settings, settling)
        self.reset()

    def configure(self, settings: ContactSettings, settling: float) -> None:
        """Change the settings; contact and everything learned stay."""
        # Read for every sample: lists are faster than arrays of seven.
        self._floor = list(settings.floor)
        self._limit = list(map(max, settings.floor, settings.limit))
        self._sigmas = settings.sigmas
        self._samples = settings.samples
        self._hysteresis = settings.hysteresis
        self._memory = settings.memory
        self._settling = settling
        self._threshold = [
            min(max(self._sigmas * sqrt(square), floor), limit)
            for square, floor, limit in zip(self._variance, self._floor, self._limit)]

    def rebase(self, change: Array) -> None:
        """
        Account for a step (7,) [N m] of the external torque caused by a change of the model.

        In free motion the bias steps as well. In contact it does not, so that adding a load to
        the model ends the contact caused by it.
        """
        if self._has_bias and not self.in_contact:
            self._bias = [min(max(x, -limit), limit)
                          for x, limit in zip((self.bias + change).tolist(), self._limit)]

    @property
    def duration(self) -> float:
        """Duration of the contact [s]."""
        return self._age

    @property
    def is_settling(self) -> bool:
        """Whether contact is unknown: the observer settles, or its first samples are undecided."""
        return self._is_undecided

    @property
    def has_learnt(self) -> bool:
        """Whether sigma covers as much free motion as its memory."""
        return self._learnt >= self._memory

    @property
    def joints(self) -> Bools:
        """Joints that show the contact, (7,): those not back, or the last that were not."""
        return np.array(self._joints)

    @property
    def bias(self) -> Array:
        """External torque of free motion, (7,) [N m]."""
        return np.array(self._bias)

    @property
    def sigma(self) -> Array:
        """RMS deviation from the bias in free motion, (7,) [N m]."""
        return np.sqrt(self._variance)

    @property
    def threshold(self) -> Array:
        """Contact threshold, as a deviation from the bias, (7,) [N m]."""
        return np.array(self._threshold)

    def reset(self) -> None:
        """Forget everything learned."""
        self._threshold = [_PRIOR * floor for floor in self._floor]
        self._variance = [(threshold / self._sigmas) ** 2 for threshold in self._threshold]
        self._learnt = 0.0  # duration of the free motion that sigma covers [s]
        self.in_contact = False
        self.restart()

    def restart(self) -> None:
        """Start a new stream: settle again, keep sigma and a contact."""
        self._to_settle = self._settling  # [s]
        self._is_undecided = True
        if not self.in_contact:
            self._bias = [0.0] * N_JOINTS
            self._has_bias = False
            self._followed = 0.0  # duration of the free motion that the bias covers [s]
            self._end()

    def update(self, dt: float, r: Array, q: Array) -> bool:
        """
        Process the next sample and return whether the arm is in contact.

        Parameters
        ----------
        dt : float
            Time since the last sample [s]; a sample with zero is ignored.
        r : ndarray (7,)
            External torque [N m].
        q : ndarray (7,)
            Position [rad].

        """
        if self._to_settle > 0.0:
            self._to_settle -= dt
        elif dt > 0.0:
            values = r.tolist()
            if not self._has_bias:
                self._initialise_bias(values)
            deviation = [x - b if x > b else b - x for x, b in zip(values, self._bias)]
            if self.in_contact:
                self._is_undecided = False
                self._moved = self._moved or bool((abs(q - self._start_q) > _MOVED).any())
                self._continue(dt, values, deviation)
            elif any(map(float.__gt__, deviation, self._threshold)):
                self._count_above(dt, deviation)
                self._start_q = q
            else:
                if self._is_suspected:
                    self._end()
                self._is_undecided = False
                self._learn(dt, values)
        return self.in_contact

    def _initialise_bias(self, values: list[float]) -> None:
        """Attribute the first sample to free motion where it is within the model error."""
        self._bias = [x if abs(x) <= limit else 0.0 for x, limit in zip(values, self._limit)]
        self._has_bias = True

    def _learn(self, dt: float, values: list[float]) -> None:
        """Update bias and sigma with a sample of free motion."""
        fast = dt / (dt + min(self._followed, _BIAS_TIME))
        slow = dt / (dt + min(self._learnt + _PRIOR_TIME, self._memory))
        self._followed += dt
        self._learnt += dt
        bias, variance, threshold, sigmas = (self._bias, self._variance, self._threshold,
                                             self._sigmas)
        i = 0
        for x, floor, limit in zip(values, self._floor, self._limit):  # written out for speed
            deviation = x - bias[i]
            share = deviation / threshold[i]
            value = bias[i] + fast * deviation * (1.0 - share * share)
            bias[i] = value if -limit < value < limit else limit if value > 0.0 else -limit
            variance[i] = square = variance[i] + slow * (deviation * deviation - variance[i])
            value = sigmas * sqrt(square)
            threshold[i] = floor if value < floor else value if value < limit else limit
            i += 1

    def _count_above(self, dt: float, deviation: list[float]) -> None:
        """Begin contact if enough consecutive samples are above the threshold."""
        self._is_suspected = True
        for i, threshold in enumerate(self._threshold):
            if deviation[i] <= threshold:
                self._count[i] = 0
                continue
            self._span[i] = self._span[i] + dt if self._count[i] else 0.0
            self._count[i] += 1
            is_enough = self._count[i] >= self._samples and (
                self._samples == 1 or self._span[i] >= _SPAN)
            if is_enough or dt >= _SPAN and deviation[i] > _FAR * threshold:
                self.in_contact = True
        if self.in_contact:
            self._is_undecided = False
            self._joints = list(map(float.__gt__, deviation, self._threshold))

    def _continue(self, dt: float, values: list[float], deviation: list[float]) -> None:
        """Continue the contact, or end it."""
        self._age += dt
        faded = min(self._age / _FADING, 1.0)
        is_explained, joints = True, []
        for i, threshold in enumerate(self._threshold):
            release = self._hysteresis * threshold
            joints.append(deviation[i] > release)
            # The reference fades from the bias to zero, and the tolerated model error grows.
            tolerance = release + faded * (self._limit[i] - release)
            if abs(values[i] - (1.0 - faded) * self._bias[i]) > tolerance:
                is_explained = False
        back = not any(joints)
        if not back:
            self._joints = joints
        self._back = self._back + dt if back else 0.0
        self._explained = self._explained + dt if is_explained else 0.0
        if self._back >= _RELEASE:
            self._end()
        elif self._explained >= _EXPLAINED:
            self._attribute_to_model(values, deviation)

    def _attribute_to_model(self, values: list[float], deviation: list[float]) -> None:
        """End the contact as a model error: adopt the bias, and after motion the threshold."""
        for i, limit in enumerate(self._limit):
            if deviation[i] <= self._hysteresis * self._threshold[i]:
                continue
            self._bias[i] = min(max(values[i], -limit), limit)
            if self._moved:  # at rest a steady push causes the same, and model errors do not grow
                self._threshold[i] = max(self._threshold[i], min(deviation[i], limit))
                self._variance[i] = max(self._variance[i],
                                        (self._threshold[i] / self._sigmas) ** 2)
        self._end()

    def _end(self) -> None:
        self.in_contact = self._is_suspected = self._moved = False
        self._joints = [False] * N_JOINTS
        self._count = [0] * N_JOINTS
        self._span = [0.0] * N_JOINTS
        self._age = self._back = self._explained = 0.0

"""
Contact: an external torque that comes faster than the model's errors do in free motion.

The bias follows the external torque of free motion within 0.15 s, and sigma is the RMS of what is
then left over 30 s of it; in contact, and with samples on the way to it, neither learns. Contact
is where a joint is further from its bias than its threshold, the larger of a floor and k sigma;
it ends where all joints are back. As the arm moves on, what its bias was counts for less: within
2.5 s contact must show more than what an uncalibrated model may be wrong by, or is given up.
"""

from collections.abc import Sequence
from math import log, sqrt

import numpy as np

from .observer import GAIN
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS

# Smallest thresholds, joint order s0 ... w2 [N m]. They count where sigma is less, as at rest.
FLOOR = (2.5, 1.0, 1.0, 0.6, 0.25, 0.4, 0.3)
# What an uncalibrated model was wrong by on recordings of two robots, at most [N m].
LIMIT = (4.0, 5.0, 4.0, 2.5, 1.2, 1.5, 0.8)
SIGMAS = 3.6
SAMPLES = 2
HYSTERESIS = 0.7
MEMORY = 30.0  # [s]
SETTLING = log(100.0) / GAIN  # [s]

# The robot's velocity is made of means over 6 ms: closer samples are no witnesses of their own.
_SPAN = 0.008  # [s]
_FAR = 1.25  # thresholds; beyond, one sample is enough if it is _SPAN or more after the last
_BIAS_TIME = 0.15  # [s]
_PRIOR = 2.0  # floors, at which the thresholds begin
_PRIOR_TIME = 1.0  # of free motion, as much as which that counts [s]
_RELEASE = 0.05  # for how long all joints must be back before contact ends [s]
_FADING = 2.5  # in which a bias loses what it is worth [s]
_MOVED = 0.05  # [rad] that an arm must move in contact for it to be an error of the model
_DOUBT = 0.3  # for how long contact must be within what the model may be wrong by [s]


class ContactDetector:
    """
    Tell contact from estimates of the external torque, and learn what free motion is like.

    Parameters
    ----------
    floor : array_like (7,)
        Smallest threshold [N m].
    sigmas : float
        k: as many sigma are the threshold, where that is more than the floor.
    samples : int
        As many in a row beyond the threshold are contact, if they span 8 ms. Where samples are
        further apart than that, one beyond 1.25 thresholds is enough.
    hysteresis : float
        A joint is back within that part of its threshold.
    limit : array_like (7,)
        What the model may be wrong by [N m]: neither bias nor k sigma grow larger.
    memory : float
        Time over which sigma is learnt [s].
    settling : float
        After a reset and a restart the observer needs as long: nothing is contact or learnt [s].

    Attributes
    ----------
    in_contact : bool
        Whether something pushes.

    """

    in_contact: bool
    _has_bias: bool
    _on_the_way: bool  # to it
    _moved: bool  # the arm did, in contact
    _from: Array  # where it was when that began (7,) [rad]
    _joints: list[bool]
    _count: list[int]  # of samples in a row beyond the threshold
    _span: list[float]  # from the first of them to the last [s]
    _age: float  # of contact [s]
    _back: float  # for how long all joints have been back [s]
    _doubted: float  # for how long it has been within what the model may be wrong by [s]

    def __init__(self, floor: Sequence[float] = FLOOR, sigmas: float = SIGMAS,
                 samples: int = SAMPLES, hysteresis: float = HYSTERESIS,
                 limit: Sequence[float] = LIMIT, memory: float = MEMORY,
                 settling: float = SETTLING) -> None:
        self._variance: list[float] = []  # of free motion's distance from the bias [N^2 m^2]
        self.configure(floor, sigmas, samples, hysteresis, limit, memory, settling)
        self.reset()

    def configure(self, floor: Sequence[float], sigmas: float, samples: int, hysteresis: float,
                  limit: Sequence[float], memory: float, settling: float) -> None:
        """Change the settings; contact and everything learned stay."""
        # A stream asks for them again and again: lists are faster than arrays of seven.
        self._floor = [float(x) for x in floor]
        self._limit = [max(x, float(y)) for x, y in zip(self._floor, limit)]
        self._sigmas = sigmas
        self._samples = samples
        self._hysteresis = hysteresis
        self._memory = memory
        self._settling = settling
        self._threshold = [min(max(sigmas * sqrt(square), floor), limit) for square, floor, limit
                           in zip(self._variance, self._floor, self._limit)]

    def rebase(self, change: Array) -> None:
        """
        Account for a change of the model by which the external torque steps (7,) [N m].

        In free motion the bias steps with it. In contact it stays: a load that the new model
        includes ends contact.
        """
        if self._has_bias and not self.in_contact:
            self._bias = [min(max(x, -limit), limit)
                          for x, limit in zip((self.bias + change).tolist(), self._limit)]

    @property
    def duration(self) -> float:
        """Return how long the contact has lasted [s]."""
        return self._age

    @property
    def is_settling(self) -> bool:
        """Whether contact is unknown: the observer settles, or its first samples are judged."""
        return self._is_undecided

    @property
    def has_learnt(self) -> bool:
        """Return whether sigma has seen as much free motion as it remembers."""
        return self._learnt >= self._memory

    @property
    def joints(self) -> Bools:
        """Which joints show the contact, (7,) bool: those not back, or the last that were not."""
        return np.array(self._joints)

    @property
    def bias(self) -> Array:
        """External torque that free motion has at present, (7,) [N m]."""
        return np.array(self._bias)

    @property
    def sigma(self) -> Array:
        """RMS of free motion's distance from the bias, (7,) [N m]."""
        return np.sqrt(self._variance)

    @property
    def threshold(self) -> Array:
        """Distance from the bias that is contact, (7,) [N m]."""
        return np.array(self._threshold)

    def reset(self) -> None:
        """Forget all that was learnt."""
        self._threshold = [_PRIOR * floor for floor in self._floor]
        self._variance = [(threshold / self._sigmas) ** 2 for threshold in self._threshold]
        self._learnt = 0.0  # free motion that sigma is made of [s]
        self.in_contact = False
        self.restart()

    def restart(self) -> None:
        """Start a new stream: unknown until the observer has settled; sigma and contact stay."""
        self._to_settle = self._settling  # [s]
        self._is_undecided = True
        if not self.in_contact:
            self._bias = [0.0] * N_JOINTS
            self._has_bias = False
            self._followed = 0.0  # free motion that the bias is made of [s]
            self._end()

    def update(self, dt: float, r: Array, q: Array) -> bool:
        """
        Take the next sample, and return whether there is contact.

        Parameters
        ----------
        dt : float
            Time since the last sample [s]; with zero nothing happens.
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
                self._take_bias(values)
            off = [x - b if x > b else b - x for x, b in zip(values, self._bias)]
            if self.in_contact:
                self._is_undecided = False
                self._moved = self._moved or bool((abs(q - self._from) > _MOVED).any())
                self._stay(dt, values, off)
            elif any(map(float.__gt__, off, self._threshold)):
                self._count_up(dt, off)
                self._from = q
            else:
                if self._on_the_way:
                    self._end()
                self._is_undecided = False
                self._learn(dt, values)
        return self.in_contact

    def _take_bias(self, values: list[float]) -> None:
        """Take the first sample for free motion, where the model may be wrong by so much."""
        self._bias = [x if abs(x) <= limit else 0.0 for x, limit in zip(values, self._limit)]
        self._has_bias = True

    def _learn(self, dt: float, values: list[float]) -> None:
        """Learn bias and sigma of a sample of free motion."""
        fast = dt / (dt + min(self._followed, _BIAS_TIME))
        slow = dt / (dt + min(self._learnt + _PRIOR_TIME, self._memory))
        self._followed += dt
        self._learnt += dt
        bias, variance, threshold, sigmas = (self._bias, self._variance, self._threshold,
                                             self._sigmas)
        i = 0
        for x, floor, limit in zip(values, self._floor, self._limit):  # written out: it is fast
            off = x - bias[i]
            part = off / threshold[i]
            value = bias[i] + fast * off * (1.0 - part * part)
            bias[i] = value if -limit < value < limit else limit if value > 0.0 else -limit
            variance[i] = square = variance[i] + slow * (off * off - variance[i])
            value = sigmas * sqrt(square)
            threshold[i] = floor if value < floor else value if value < limit else limit
            i += 1

    def _count_up(self, dt: float, off: list[float]) -> None:
        """Begin contact, if enough samples are beyond the threshold; some are."""
        self._on_the_way = True
        for i, threshold in enumerate(self._threshold):
            if off[i] <= threshold:
                self._count[i] = 0
                continue
            self._span[i] = self._span[i] + dt if self._count[i] else 0.0
            self._count[i] += 1
            in_a_row = self._count[i] >= self._samples and (
                self._samples == 1 or self._span[i] >= _SPAN)
            if in_a_row or dt >= _SPAN and off[i] > _FAR * threshold:
                self.in_contact = True
        if self.in_contact:
            self._is_undecided = False
            self._joints = list(map(float.__gt__, off, self._threshold))

    def _stay(self, dt: float, values: list[float], off: list[float]) -> None:
        """Go on with contact, or end it."""
        self._age += dt
        faded = min(self._age / _FADING, 1.0)
        doubtful, joints = True, []
        for i, threshold in enumerate(self._threshold):
            release = self._hysteresis * threshold
            joints.append(off[i] > release)
            # The reference goes over from the bias to zero, and what it may be wrong by grows.
            wrong = release + faded * (self._limit[i] - release)
            if abs(values[i] - (1.0 - faded) * self._bias[i]) > wrong:
                doubtful = False
        back = not any(joints)
        if not back:
            self._joints = joints
        self._back = self._back + dt if back else 0.0
        self._doubted = self._doubted + dt if doubtful else 0.0
        if self._back >= _RELEASE:
            self._end()
        elif self._doubted >= _DOUBT:
            self._give_up(values, off)

    def _give_up(self, values: list[float], off: list[float]) -> None:
        """Take contact for an error of the model after all, to come again if the arm moved."""
        for i, limit in enumerate(self._limit):
            if off[i] <= self._hysteresis * self._threshold[i]:
                continue
            self._bias[i] = min(max(values[i], -limit), limit)
            if self._moved:  # a still arm shows no new errors of the model: something leans on it
                self._threshold[i] = max(self._threshold[i], min(off[i], limit))
                self._variance[i] = max(self._variance[i],
                                        (self._threshold[i] / self._sigmas) ** 2)
        self._end()

    def _end(self) -> None:
        self.in_contact = self._on_the_way = self._moved = False
        self._joints = [False] * N_JOINTS
        self._count = [0] * N_JOINTS
        self._span = [0.0] * N_JOINTS
        self._age = self._back = self._doubted = 0.0

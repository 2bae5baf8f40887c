r"""
The generalised-momentum observer: external joint torque without accelerations.

For ``M qdd + C qd + G = tau + tau_ext`` the momentum p = M qd obeys ``dp/dt = tau + C^T qd - G +
tau_ext``. The observer integrates what is known of that, and what it lacks is tau_ext.
"""

from math import log

import numpy as np

from ..model.arrays import Array

GAIN = 10.0  # [1/s]


class MomentumObserver:
    r"""
    Estimate r of ``r = K (p - integral(rate + r) dt - p(0))``: r' = K (tau_ext - r).

    Integrated by the backward Euler method with the true time step of every sample, solved for
    r, which is stable for any step.

    Parameters
    ----------
    gain : float
        K [1/s]: r follows tau_ext like a first-order low-pass with the time constant 1 / K.

    Attributes
    ----------
    gain : float
        K [1/s]; may be changed between two samples.
    r : ndarray (7,) or None
        The newest estimate of tau_ext [N m]; None before the first sample.

    """

    def __init__(self, gain: float = GAIN) -> None:
        self.gain = gain
        self.reset()

    @property
    def settling_time(self) -> float:
        """Time in which the initial error decays to 1 % [s]."""
        return log(100.0) / self.gain

    def reset(self) -> None:
        """Forget all samples: the next is the first, with r = 0."""
        self._momentum: Array = np.zeros(0)  # at the last sample [N m s]
        self.r: Array | None = None

    def rebase(self, momentum: Array, r: Array) -> None:
        """
        Change the model between two samples.

        Parameters
        ----------
        momentum : ndarray (7,)
            Difference of the new model's momentum to the old one's at the last sample [N m s].
        r : ndarray (7,)
            Difference of the external torque by the new model to the one by the old [N m].

        """
        if self.r is not None:
            self._momentum = self._momentum + momentum
            self.r = self.r + r

    def update(self, dt: float, momentum: Array, rate: Array) -> Array:
        """
        Take the next sample, and return r (7,) [N m].

        Parameters
        ----------
        dt : float
            Time since the last sample [s], not negative; of no effect on the first. With zero, r
            changes by what the momentum changed.
        momentum : ndarray (7,)
            p = M qd [N m s].
        rate : ndarray (7,)
            What dp/dt is without external torque: tau + C^T qd - G [N m].

        """
        if self.r is None:
            self.r = np.zeros(len(momentum))
        else:
            # r = K (p - p_hat) and p_hat = p_hat_last + (rate + r) dt, where p_hat = p - r / K
            gain = self.gain
            lacking = momentum - self._momentum - dt * rate  # [N m s]
            self.r = (self.r + gain * lacking) * (1.0 / (1.0 + gain * dt))
        self._momentum = momentum
        return self.r

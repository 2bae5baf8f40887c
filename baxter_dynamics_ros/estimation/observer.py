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
    r : ndarray (7,) or None
        The newest estimate of tau_ext [N m]; None before the first sample.
    settling_time : float
        Time in which what the observer began with decays to 1 % [s].

    """

    def __init__(self, gain: float = GAIN) -> None:
        self._gain = gain
        self.settling_time = log(100.0) / gain
        self.reset()

    def reset(self) -> None:
        """Forget all samples: the next is the first, with r = 0."""
        self._momentum: Array = np.zeros(0)  # at the last sample [N m s]
        self.r: Array | None = None

    def rebase(self, change: Array) -> None:
        """
        Let the model change between two samples, so that r goes on from where it is.

        Parameters
        ----------
        change : ndarray (7,)
            What the new model's momentum has beyond the old one's at the last sample [N m s].

        """
        if self.r is not None:
            self._momentum = self._momentum + change

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
            gain = self._gain
            lacking = momentum - self._momentum - dt * rate  # [N m s]
            self.r = (self.r + gain * lacking) * (1.0 / (1.0 + gain * dt))
        self._momentum = momentum
        return self.r

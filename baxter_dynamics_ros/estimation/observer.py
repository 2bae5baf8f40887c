r"""
Generalised-momentum observer: external joint torque without accelerations.

For ``M qdd + C qd + G = tau + tau_ext`` the momentum p = M qd obeys ``dp/dt = tau + C^T qd - G +
tau_ext``. The observer integrates the known terms; the difference from p reveals tau_ext.
"""

from math import log

import numpy as np

from ..model.arrays import Array


class MomentumObserver:
    r"""
    Estimates tau_ext by ``r = K (p - integral(rate + r) dt - p(0))``: r' = K (tau_ext - r).

    Integrated by the backward Euler method with the true time step of every sample, which is
    stable for any step.

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

    def __init__(self, gain: float) -> None:
        self.gain = gain
        self.reset()

    @property
    def settling_time(self) -> float:
        """Time in which the initial error decays to 1 % [s]."""
        return log(100.0) / self.gain

    def reset(self) -> None:
        """Forget all samples; r is zero at the next one."""
        self._momentum: Array = np.zeros(0)  # at the last sample [N m s]
        self.r: Array | None = None

    def rebase(self, momentum: Array, r: Array) -> None:
        """
        Account for a change of the model between two samples.

        It changes the momentum at the last sample [N m s] and r [N m] by these differences, (7,)
        each, of the new and the old model.
        """
        if self.r is not None:
            self._momentum = self._momentum + momentum
            self.r = self.r + r

    def update(self, dt: float, momentum: Array, rate: Array) -> Array:
        """
        Process the next sample and return r (7,) [N m].

        Parameters
        ----------
        dt : float
            Time since the last sample [s], not negative; ignored for the first. If zero, r changes
            by K times the change of the momentum.
        momentum : ndarray (7,)
            p = M qd [N m s].
        rate : ndarray (7,)
            dp/dt without external torque: tau + C^T qd - G [N m].

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

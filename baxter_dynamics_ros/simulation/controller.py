"""The paper's double-loop position controller, eqs. (13) and (14), over gravity compensation."""

import numpy as np

# Gains, joint order s0 ... w2. The paper states none; these settle each joint within 0.3 s.
KP_OUTER = 15.0  # [1/s]
KD_OUTER = 0.3
KP_INNER = np.array([40.0, 40.0, 15.0, 15.0, 1.0, 1.5, 0.1])  # [N m s/rad]
KI_INNER = 6.0 * KP_INNER  # [N m/rad]


class DoubleLoop:
    """
    Follow joint references: the outer loop asks for a velocity, the inner one for torques.

    Parameters
    ----------
    standing : array_like (7,)
        What its integral supplies at first, beyond the compensation: as if it had long been
        holding the arm where it starts [N m].

    """

    def __init__(self, standing=np.zeros(len(KP_INNER))):
        self._integral = standing / KI_INNER

    def torque(self, q_r, qd_r, q, qd, holding, dt: float) -> np.ndarray:
        """
        Return motor torques (7,) [N m].

        Parameters
        ----------
        q_r, qd_r : ndarray (7,)
            Reference [rad, rad/s].
        q, qd : ndarray (7,)
            State [rad, rad/s].
        holding : ndarray (7,)
            Gravity and spring compensation, which the robot adds by itself [N m].
        dt : float
            Time since the last call [s].

        """
        wanted = KP_OUTER * (q_r - q) + KD_OUTER * (qd_r - qd)  # (13)
        # (14); the text prints q_r for the velocity qd in the error of the inner loop.
        error = wanted - qd
        self._integral += error * dt
        return holding + KP_INNER * error + KI_INNER * self._integral

"""The paper's double-loop position controller, eqs. (13) and (14), over gravity compensation."""

import numpy as np

from ..model.arrays import Array

# Gains, joint order s0 ... w2. The paper states none; these settle each joint within 0.3 s.
KP_OUTER = 15.0  # [1/s]
KD_OUTER = 0.3
KP_INNER = np.array([40.0, 40.0, 15.0, 15.0, 1.0, 1.5, 0.1])  # [N m s/rad]
KI_INNER = 6.0 * KP_INNER  # [N m/rad]


class DoubleLoop:
    """
    Cascaded position controller: an outer velocity loop, eq. (13), around an inner one, eq. (14).

    Its integral starts with ``standing`` torques (7,) [N m], as if the controller had held the
    arm in place for a long time.
    """

    def __init__(self, standing: Array = np.zeros(len(KP_INNER))) -> None:
        self._integral = standing / KI_INNER

    def torque(self, q_r: Array, qd_r: Array, q: Array, qd: Array,
               holding: Array, dt: float) -> Array:
        """
        Return motor torques (7,) [N m] for a reference and a state, each (7,) [rad, rad/s].

        ``holding`` (7,) is the gravity and spring compensation [N m], dt the time since the last
        call [s].
        """
        error = _velocity_error(q_r, qd_r, q, qd)
        self._integral = self._integral + error * dt
        return holding + KP_INNER * error + KI_INNER * self._integral

    def start_at(self, motor: Array, q_r: Array, qd_r: Array, q: Array,
                 qd: Array, holding: Array, dt: float) -> None:
        """
        Set the integral so that the next :meth:`torque` returns ``motor`` (7,) [N m].

        The other arguments are those of that call.
        """
        error = _velocity_error(q_r, qd_r, q, qd)
        self._integral = (motor - holding - KP_INNER * error) / KI_INNER - error * dt


def _velocity_error(q_r: Array, qd_r: Array, q: Array, qd: Array) -> Array:
    """Return the velocity error of the inner loop, (7,) [rad/s]."""
    wanted = KP_OUTER * (q_r - q) + KD_OUTER * (qd_r - qd)  # (13)
    return wanted - qd  # of (14), whose text prints q_r for the velocity qd

"""The arm's mechanics: MuJoCo on the manufacturer's numbers, with springs and friction."""

import mujoco
import numpy as np

from .description import arm_description
from ..core.effort import COULOMB_VELOCITY
from ..core.effort import EffortModel
from ..core.joints import joint_names
from ..core.joints import N_JOINTS

TIMESTEP = 0.001  # [s]

# Coulomb friction of the simulated arm [N m], of the size seen on real ones.
COULOMB = (0.4, 0.7, 0.3, 0.3, 0.1, 0.1, 0.03)

_COMPILER = ('<mujoco><compiler fusestatic="false" balanceinertia="false"/>'
             '<option timestep="{timestep}" integrator="implicitfast">'
             '<flag contact="disable" constraint="disable"/></option></mujoco>')


class Plant:
    """
    One arm that moves under motor torques; joint order s0 ... w2.

    Motor torques work against the springs at s1 and friction, as on the robot:
    ``M qdd + C qd + G = motor - spring(q) - friction(qd) + J^T force``.

    Parameters
    ----------
    side : str
        'right' or 'left'.
    description : path, optional
        A Baxter's URDF; the one of ``hpp-baxter`` by default.
    spring, friction : bool
        Whether the arm has the springs at s1, and friction.

    """

    def __init__(self, side: str, description=None, spring: bool = True, friction: bool = True):
        urdf = arm_description(side, description)
        root_end = urdf.index('>', urdf.index('<robot')) + 1
        self.model = mujoco.MjModel.from_xml_string(
            urdf[:root_end] + _COMPILER.format(timestep=TIMESTEP) + urdf[root_end:])
        self.model.dof_damping[:] = 0.0  # the description's 0.7 is no measurement
        self.data = mujoco.MjData(self.model)
        self._still = mujoco.MjData(self.model)
        names = [self.model.joint(i).name for i in range(self.model.njnt)]
        self._joints = np.array([names.index(name) for name in joint_names(side)])
        self._hand = self.model.body(f'{side}_hand_link').id
        default = EffortModel()
        self._passive = EffortModel(
            spring_coefficients=default.spring_coefficients if spring else np.zeros(5),
            coulomb=COULOMB if friction else np.zeros(N_JOINTS),
            coulomb_velocity=COULOMB_VELOCITY)
        self.force = np.zeros(3)  # at the hand, axes of the robot's base [N]

    @property
    def q(self) -> np.ndarray:
        """Position (7,) [rad]."""
        return self.data.qpos[self._joints]

    @property
    def qd(self) -> np.ndarray:
        """Velocity (7,) [rad/s]."""
        return self.data.qvel[self._joints]

    def place(self, q: np.ndarray):
        """Put the arm at rest at q (7,) [rad]."""
        self.data.qpos[self._joints] = q
        self.data.qvel[:] = 0.0
        mujoco.mj_forward(self.model, self.data)

    def holding_torque(self) -> np.ndarray:
        """Return the motor torques (7,) [N m] that hold the arm against gravity and springs."""
        self._still.qpos[:] = self.data.qpos
        mujoco.mj_kinematics(self.model, self._still)
        mujoco.mj_comPos(self.model, self._still)
        gravity = np.zeros(self.model.nv)
        mujoco.mj_rne(self.model, self._still, 0, gravity)
        return gravity[self._joints] + self._passive.spring(self.q)

    def step(self, motor: np.ndarray):
        """Advance by one time step under motor torques (7,) [N m]."""
        q, qd = self.q, self.qd
        applied = self.data.qfrc_applied
        applied[:] = 0.0
        applied[self._joints] = motor - self._passive.spring(q) - self._passive.friction(qd)
        if self.force.any():
            mujoco.mj_applyFT(self.model, self.data, self.force, np.zeros(3),
                              self.data.xpos[self._hand], self._hand, applied)
        mujoco.mj_step(self.model, self.data)

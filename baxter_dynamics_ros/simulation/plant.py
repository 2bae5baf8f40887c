"""One arm: MuJoCo on the manufacturer's description, springs, friction, and the sensors."""

from collections import deque
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from .description import arm_description, DescriptionError, hand_names
from ..model import (ArgumentError, Array, EffortModel, finite, joint_names, N_JOINTS, Payload,
                     Presliding)
from ..model.paper_tables import GRAVITY

TIMESTEP = 0.001  # of the simulation and of the encoder's readings [s]

# Coulomb friction of the simulated arm, similar to that of real arms [N m].
COULOMB = (0.4, 0.7, 0.3, 0.3, 0.1, 0.1, 0.03)

# Torque limits of the manufacturer's robot description [N m].
TORQUE_LIMIT = np.array([50.0, 50.0, 50.0, 50.0, 15.0, 15.0, 15.0])

# Sensors, measured on real arms at rest; joint order s0 ... w2.
POSITION_QUANTUM = 2 * np.pi / 16384  # [rad]
EFFORT_QUANTUM = 0.004  # [N m]
EFFORT_NOISE = np.array([0.075, 0.037, 0.075, 0.035, 0.008, 0.016, 0.011])  # sd [N m]
# Chosen so that the published velocity has the measured noise of 0.013 rad/s.
ENCODER_NOISE = 4.8e-4  # sd [rad]

# The published velocity is the difference of two means over 6 encoder readings, 22 readings
# apart, which makes it lag by (2.5 + 24.5) / 2 = 13.5 ms.
MEAN_LENGTH = 6
DISTANCE = 22

_MOST_PENDING = 1000  # positions sampled at once; bounds memory

_COMPILER = ('<mujoco><compiler fusestatic="false" balanceinertia="false"/>'
             f'<option timestep="{TIMESTEP}" integrator="implicitfast">'
             '<flag contact="disable" constraint="disable"/></option></mujoco>')


def default_truth(spring: bool = True, friction: bool = True) -> EffortModel:
    """Return the default effort model of the simulated arm: spring at s1, Coulomb friction."""
    return replace(EffortModel() if spring else EffortModel.rigid(),
                   coulomb=np.array(COULOMB) if friction else np.zeros(N_JOINTS))


class Plant:
    """
    One simulated arm driven by motor torques; joint order s0 ... w2.

    ``M qdd + C qd + G = motor - spring(q) - stiffness q - friction - added_inertia qdd
    + J^T force + torque``. The bias of the effort model belongs to the sensors. By default the
    description is that of ``hpp-baxter``, the true effort model :func:`default_truth`, and
    gravity (3,) [m/s^2], in the base frame, straight down. The robot's own compensation knows
    neither payload nor tilt nor cables.
    """

    def __init__(self, side: str, description: Path | str | None = None,
                 truth: EffortModel | None = None, payload: Payload | None = None,
                 gravity: ArrayLike | None = None) -> None:
        self.truth = default_truth() if truth is None else truth
        if self.truth.added_inertia.min() < 0.0:
            raise ArgumentError('truth.added_inertia', 'expected no negative value, got '
                                f'{self.truth.added_inertia}')
        self.force: Array = np.zeros(3)  # external force on the hand, base axes [N]
        self.torque: Array = np.zeros(N_JOINTS)  # external torque on the joints [N m]
        self.model = _compile(arm_description(side, description, payload))
        self.model.opt.gravity[:] = finite(
            'gravity', GRAVITY if gravity is None else gravity, (3,))
        self._joints = np.array([self.model.joint(name).id for name in joint_names(side)])
        self.model.dof_armature[self._joints] = self.truth.added_inertia
        self.data = mujoco.MjData(self.model)
        self._hand = next(i for i in range(self.model.nbody)
                          if self.model.body(i).name in hand_names(side))
        nominal = _compile(arm_description(side, description))
        self._nominal = nominal, mujoco.MjData(nominal)
        self._actual = self.model, mujoco.MjData(self.model)
        self._presliding = Presliding(self.truth.presliding_length)
        self._read_state()

    def _read_state(self) -> None:
        self.q: Array = self.data.qpos[self._joints]  # (7,) [rad]
        self.qd: Array = self.data.qvel[self._joints]  # (7,) [rad/s]
        self._spring = self.truth.spring(self.q)  # (7,) [N m]

    def place(self, q: Array) -> None:
        """Place the arm at rest at q (7,) [rad], without stored friction."""
        self.data.qpos[self._joints] = q
        self.data.qvel[:] = 0.0
        self._presliding.reset()
        mujoco.mj_forward(self.model, self.data)
        self._read_state()

    def holding_torque(self) -> Array:
        """Return the robot's own compensation of gravity and spring, (7,) [N m]."""
        return self._gravity(*self._nominal) + self._spring

    def static_torque(self) -> Array:
        """Return the motor torques that hold the arm at rest without friction, (7,) [N m]."""
        return self._gravity(*self._actual) + self._spring + self.truth.stiffness * self.q

    def step(self, motor: Array) -> None:
        """Advance by one time step under motor torques (7,) [N m]."""
        friction = self.truth.friction(self.qd, self._presliding.update(self.q))
        applied = self.data.qfrc_applied
        applied[:] = 0.0
        applied[self._joints] = (motor - self._spring - friction - self.truth.stiffness * self.q
                                 + self.torque)
        if self.force.any():
            mujoco.mj_applyFT(self.model, self.data, self.force, np.zeros(3),
                              self.data.xpos[self._hand], self._hand, applied)
        mujoco.mj_step(self.model, self.data)
        self._read_state()

    def _gravity(self, model: mujoco.MjModel, data: mujoco.MjData) -> Array:
        """Return the torques (7,) [N m] that balance gravity at rest, by another model."""
        data.qpos[:] = self.data.qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_rne(model, data, 0, data.qfrc_bias)
        return data.qfrc_bias[self._joints]


def _compile(urdf: str) -> mujoco.MjModel:
    try:
        model = mujoco.MjModel.from_xml_string(urdf.replace('</robot>', _COMPILER + '</robot>'))
    except ValueError as error:
        reason = ' '.join(str(error).partition(', line')[0].split())  # lines of the arm alone
        raise DescriptionError(f'MuJoCo refuses the robot description: {reason}') from None
    model.dof_damping[:] = 0.0  # the value 0.7 in the description was never measured
    return model


class Sensors:
    """Joint sensors of one arm; without noise there is no quantisation, but the same lag."""

    def __init__(self, noise: bool = True, seed: int = 0) -> None:
        self._noise = noise
        self._random = np.random.default_rng(seed)
        self._encoder: deque[Array] = deque(maxlen=MEAN_LENGTH + DISTANCE)
        self._pending: list[Array] = []  # true positions (7,) not yet sampled by the encoder [rad]

    def read(self, q: Array) -> None:
        """Read the true position (7,) [rad], once every TIMESTEP."""
        self._pending.append(q)
        if len(self._pending) == _MOST_PENDING:
            self._sample()

    def publish(self, effort: Array) -> tuple[Array, Array, Array]:
        """
        Return position [rad], velocity [rad/s] and effort [N m] as the robot publishes them.

        ``effort`` (7,) [N m] is the true one.
        """
        if self._pending:
            self._sample()
        readings = np.array(self._encoder)
        velocity = (readings[-MEAN_LENGTH:].mean(0) - readings[:MEAN_LENGTH].mean(0)) / (
            DISTANCE * TIMESTEP)
        if self._noise:
            effort = _quantised(effort + EFFORT_NOISE * self._random.standard_normal(N_JOINTS),
                                EFFORT_QUANTUM)
        return readings[-1], velocity, effort

    def _sample(self) -> None:
        """Sample the pending positions with the encoder."""
        q = np.array(self._pending)
        self._pending.clear()
        if self._noise:
            q = _quantised(q + ENCODER_NOISE * self._random.standard_normal(q.shape),
                           POSITION_QUANTUM)
        if not self._encoder:  # the arm was at rest before the first reading
            self._encoder.extend([q[0]] * (MEAN_LENGTH + DISTANCE))
        self._encoder.extend(q)


def _quantised(x: Array, quantum: float) -> Array:
    return np.round(x / quantum) * quantum

"""Fake Baxter, without ROS: the paper's double-loop position controller, and joint states."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from . import exciting_trajectory
from .plant import Plant, Sensors, TIMESTEP, TORQUE_LIMIT
from .trajectories import HandTrajectory, JointTrajectory, mirror, poses
from ..model import (ArgumentError, Array, EffortModel, finite, joint_names, JOINTS, N_JOINTS,
                     Payload, SIDES, VELOCITY_LIMIT)

# The order in which the robot publishes.
JOINT_STATE_NAMES = tuple(sorted(
    ('head_nod', 'head_pan', *joint_names('left'), *joint_names('right'), 'torso_t0')))
GRIPPER_NAMES = ('r_gripper_l_finger_joint', 'r_gripper_r_finger_joint')
GRIPPER_RATE = 38.0  # [Hz]
Message = tuple[int, tuple[str, ...], Array, Array, Array]  # stamp [ns], names, q, qd, effort
STAMP_JITTER = 4e-5  # sd of the robot's own stamps [s]
START_NS = 10 ** 18  # stamp of a recording's start, a date in 2001 [ns]
_TOLERANCE_NS = 500_000  # on a recording's end; the jitter of stamps is far smaller

TRAJECTORIES = ('circle', 'switch', 'lift', 'exciting', 'hold', 'poses')

COMMAND_TIMEOUT = 0.2  # how long a torque command stays in force, as in the SDK [s]
# Above this speed torque commands are refused. There are no joint stops, and maximum torque makes
# w2 fast enough within 0.2 s for MuJoCo to diverge [rad/s].
RUNAWAY = 10 * VELOCITY_LIMIT

_REFERENCE_STEPS = 10  # time steps between two reference updates, linear in between

# Gains of the controller, eqs. (13) and (14), joint order s0 ... w2. The paper states none; these
# settle each joint within 0.3 s.
KP_OUTER = 15.0  # [1/s]
KD_OUTER = 0.3
KP_INNER = np.array([40.0, 40.0, 15.0, 15.0, 1.0, 1.5, 0.1])  # [N m s/rad]
KI_INNER = 6.0 * KP_INNER  # [N m/rad]


class FakeBaxter:
    """
    Simulated Baxter: the arm of a side follows one of :data:`TRAJECTORIES`, the other is at rest.

    The seed is that of the sensors' noise. Both arms have the effort model ``truth``; the moving
    hand holds the payload. For these, gravity and the path of the description, see
    :class:`.plant.Plant`. Raises ArgumentError if the trajectory is unknown, or as the plant does.
    """

    def __init__(self, side: str = 'right', trajectory: str = 'circle',
                 description: Path | str | None = None, noise: bool = True, seed: int = 0,
                 truth: EffortModel | None = None, payload: Payload | None = None,
                 gravity: ArrayLike | None = None) -> None:
        if trajectory not in TRAJECTORIES:
            raise ArgumentError('trajectory', f'expected one of {", ".join(TRAJECTORIES)}, '
                                f'got {trajectory!r}')
        self.plant = Plant(side, description, truth, payload, gravity)
        self.reference: HandTrajectory | JointTrajectory = _reference(side, trajectory)
        self.plant.place(self.reference.q)
        self._motor = self.plant.static_torque()  # latest motor torques (7,) [N m]
        # Of the controller's inner loop [rad], as if it had held the arm in place for long.
        self._integral = (self._motor - self.plant.holding_torque()) / KI_INNER
        self._sensors = Sensors(noise, seed)
        self._steps = self._command_ends = 0
        self._command: Array | None = None  # commanded motor torques, if any
        other = SIDES[1 - SIDES.index(side)]
        resting = Plant(other, description, truth, gravity=gravity)
        resting.place(HandTrajectory(other, 'hold').q)
        self._resting = Sensors(noise, seed + 1)
        self._resting_q, self._resting_torque = resting.q, resting.static_torque()
        simulated = joint_names(side) + joint_names(other)
        self._order = [simulated.index(name) if name in simulated else len(simulated)
                       for name in JOINT_STATE_NAMES]  # head and torso stay at zero
        self._read_encoders()

    @property
    def time(self) -> float:
        """Time since the start of the simulation [s]."""
        return self._steps * TIMESTEP

    @property
    def is_commanded(self) -> bool:
        """Whether a torque command is in force."""
        return self._command is not None

    def command(self, torque: ArrayLike) -> None:
        """
        Apply motor torques (7,) [N m] and nothing else, as in the SDK's torque mode.

        They are the measured effort without bias and noise, and stay in force until the next
        command or for :data:`COMMAND_TIMEOUT`. Then the controller holds the arm in place,
        starting from the present torques; the trajectory is not resumed. A joint faster than
        :data:`RUNAWAY` is braked immediately.

        Raises ArgumentError if it is not seven finite numbers, each within
        :data:`.plant.TORQUE_LIMIT`, or a joint is too fast. The previous command then stays.
        """
        command = finite('torque', torque, (N_JOINTS,)).copy()
        beyond = np.flatnonzero(np.abs(command) > TORQUE_LIMIT)
        if len(beyond):
            joint = beyond[0]
            raise ArgumentError('torque', f'expected at most {TORQUE_LIMIT[joint]:g} N m at '
                                f'{JOINTS[joint]}, got {command[joint]:g}')
        if self._runs_away():
            joint = np.argmax(np.abs(self.plant.qd) / RUNAWAY)
            raise ArgumentError('torque', f'{JOINTS[joint]} is too fast and is being braked')
        self._command = command
        self._command_ends = self._steps + round(COMMAND_TIMEOUT / TIMESTEP)

    def advance(self, time: float) -> None:
        """Simulate until ``time`` [s since the start]."""
        while self.time < time - TIMESTEP / 2:
            if self._command is not None and (
                    self._steps >= self._command_ends or self._runs_away()):
                self._hold_here()
                self._command = None
            self._motor = self._control() if self._command is None else self._command
            self.plant.step(self._motor)
            self._read_encoders()
            self._steps += 1

    def joint_state(self) -> tuple[Array, Array, Array]:
        """Return position, velocity and effort, each (17,), in :data:`JOINT_STATE_NAMES`."""
        truth = self.plant.truth
        moving = self._sensors.publish(truth.coupled(self._motor + truth.bias))
        still = self._resting.publish(truth.coupled(self._resting_torque + truth.bias))
        position, velocity, effort = (
            np.concatenate([*pair, [0.0]])[self._order] for pair in zip(moving, still))
        return position, velocity, effort

    def _read_encoders(self) -> None:
        self._sensors.read(self.plant.q)
        self._resting.read(self._resting_q)

    def _control(self) -> Array:
        """Return the controller's motor torques (7,) [N m]."""
        ahead = -self._steps % _REFERENCE_STEPS
        if ahead == 0:
            self.reference.advance(_REFERENCE_STEPS * TIMESTEP)
            ahead = _REFERENCE_STEPS
        error = self._velocity_error(self.reference.q - ahead * TIMESTEP * self.reference.qd)
        self._integral = self._integral + error * TIMESTEP
        return (self.plant.holding_torque() + KP_INNER * error
                + KI_INNER * self._integral)  # (14), over gravity and spring compensation

    def _velocity_error(self, q_r: Array) -> Array:
        """Return the velocity error (7,) [rad/s] of the inner loop for a reference (7,) [rad]."""
        q, qd = self.plant.q, self.plant.qd
        wanted = KP_OUTER * (q_r - q) + KD_OUTER * (self.reference.qd - qd)  # (13)
        return wanted - qd  # of (14), whose text prints q_r for the velocity qd

    def _hold_here(self) -> None:
        """Hold the present position, starting from the present motor torques."""
        here = self.plant.q
        self.reference = JointTrajectory(lambda t: here)
        if self._runs_away():
            self._integral = np.zeros(N_JOINTS)  # without the torques that accelerate the joint
        else:
            error = self._velocity_error(here)
            held = self._motor - self.plant.holding_torque() - KP_INNER * error  # [N m]
            self._integral = held / KI_INNER - error * TIMESTEP

    def _runs_away(self) -> bool:
        return bool((np.abs(self.plant.qd) > RUNAWAY).any())


def _reference(side: str, trajectory: str) -> HandTrajectory | JointTrajectory:
    """Return the joint references of a trajectory."""
    if trajectory == 'exciting':
        series = exciting_trajectory.series(side)
        return JointTrajectory(lambda t: exciting_trajectory.motion(series, t)[0])
    if trajectory == 'poses':
        return JointTrajectory(lambda t: mirror(side) * poses(t))
    return HandTrajectory(side, trajectory)


class JointStates:
    """
    Joint states that a robot publishes from its present time.

    The head and both arms are published at ``rate`` [Hz], two gripper joints at 38 Hz. Each
    message advances the simulation to its instant.
    """

    def __init__(self, robot: FakeBaxter, rate: float, seed: int, start_ns: int):
        self.start_ns = start_ns  # stamp of the start [ns]; assign a later value to skip time
        self._robot = robot
        self._begin = robot.time
        self._period = 1.0 / rate
        self._random = np.random.default_rng(seed)
        self._arms = self._grippers = 0  # number of messages
        self._arms_due = self._draw()
        self._grippers_due = _ns(1.0 / GRIPPER_RATE)

    @property
    def due_ns(self) -> int:
        """Stamp of the next message [ns]."""
        return self.start_ns + min(self._arms_due, self._grippers_due)

    def take(self) -> Message:
        """Return stamp [ns], names, position, velocity and effort of the next message."""
        stamp = self.due_ns
        if self._grippers_due < self._arms_due:
            self._grippers += 1
            self._grippers_due = _ns((self._grippers + 1) / GRIPPER_RATE)
            still = np.zeros(len(GRIPPER_NAMES))
            return stamp, GRIPPER_NAMES, still, still, still
        self._arms += 1
        self._robot.advance(self._begin + self._arms * self._period)
        self._arms_due = self._draw()
        return stamp, JOINT_STATE_NAMES, *self._robot.joint_state()

    def _draw(self) -> int:
        """Return the stamp of the arms' next joint state, relative to the start [ns]."""
        return _ns((self._arms + 1) * self._period + self._random.normal(0.0, STAMP_JITTER))


def record(robot: FakeBaxter, duration: float, rate: float, seed: int = 0) -> Iterator[Message]:
    """
    Yield the joint states of the robot's next ``duration`` [s], faster than real time.

    The arms' rate is in Hz, the seed is that of the stamps' jitter, and the stamps begin at
    :data:`START_NS`.
    """
    states = JointStates(robot, rate, seed, START_NS)
    while states.due_ns < START_NS + _ns(duration) + _TOLERANCE_NS:
        yield states.take()


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)

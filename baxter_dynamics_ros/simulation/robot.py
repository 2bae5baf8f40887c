"""The fake Baxter: plant, controller and sensors put together; knows no ROS."""

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from .controller import DoubleLoop
from .exciting_trajectory import Excitation
from .plant import default_truth, Plant, TIMESTEP, TORQUE_LIMIT
from .poses import Poses, Still
from .sensors import Sensors
from .trajectories import Along, Reference
from ..model.arrays import Array
from ..model.effort import EffortModel
from ..model.exceptions import ArgumentError
from ..model.joints import joint_names, JOINTS, N_JOINTS, SIDES, VELOCITY_LIMIT
from ..model.parameters import Payload
from ..model.validation import finite

# The order in which the robot publishes: head, then each arm in alphabetical order, torso.
_ALPHABETICAL = ('e0', 'e1', 's0', 's1', 'w0', 'w1', 'w2')
JOINT_STATE_NAMES = (('head_nod', 'head_pan')
                     + tuple(f'{side}_{joint}' for side in ('left', 'right')
                             for joint in _ALPHABETICAL)
                     + ('torso_t0',))
GRIPPER_NAMES = ('r_gripper_l_finger_joint', 'r_gripper_r_finger_joint')
GRIPPER_RATE = 38.0  # [Hz]

TRAJECTORIES = ('circle', 'switch', 'lift', 'exciting', 'hold', 'poses')

COMMAND_TIMEOUT = 0.2  # [s] for which a torque command holds, as the SDK has it
# Faster, no torque command is obeyed: there are no stops, and a motor's limit makes w2 so fast
# within 0.2 s that MuJoCo gives up and puts the arm elsewhere [rad/s].
RUNAWAY = 10 * VELOCITY_LIMIT

_REFERENCE_STEPS = 10  # time steps between two updates of the reference, a line between them


class FakeBaxter:
    """
    A Baxter whose one arm follows a trajectory while the other is held still.

    Parameters
    ----------
    side : str
        The arm that moves, 'right' or 'left'.
    trajectory : str
        One of :data:`TRAJECTORIES`: the paper's, the :mod:`.excitation`, the :mod:`.poses`, or
        standing still.
    description : path, optional
        A Baxter's URDF.
    spring, friction, noise : bool
        Whether the robot has springs at s1, friction, and sensor noise.
    seed : int
        Of the noise.
    truth : EffortModel, optional
        What the measured effort of both arms truly has beyond tau, in the place of ``spring``
        and ``friction``; :func:`.plant.default_truth` by default.
    payload : Payload, optional
        What the moving hand carries; unknown to the robot.
    gravity : array_like (3,), optional
        Gravity vector in the base frame [m/s^2], straight down by default; unknown to the
        robot.

    Raises
    ------
    ArgumentError
        If trajectory is unknown, truth is given while ``spring`` or ``friction`` is False, or
        :class:`.plant.Plant` refuses an argument.

    """

    def __init__(self, side: str = 'right', trajectory: str = 'circle',
                 description: Path | str | None = None, spring: bool = True,
                 friction: bool = True, noise: bool = True, seed: int = 0,
                 truth: EffortModel | None = None, payload: Payload | None = None,
                 gravity: ArrayLike | None = None) -> None:
        if trajectory not in TRAJECTORIES:
            raise ArgumentError('trajectory', f'expected one of {", ".join(TRAJECTORIES)}, '
                                f'got {trajectory!r}')
        if truth is None:
            truth = default_truth(spring, friction)
        elif not (spring and friction):
            raise ArgumentError('truth', 'says what spring and friction there are: leave the '
                                'arguments spring and friction out')
        self.plant = Plant(side, description, truth, payload, gravity)
        self.reference: Reference | Along = _reference(side, trajectory)
        self.plant.place(self.reference.q)
        standing = self.plant.static_torque()
        self._controller = DoubleLoop(standing - self.plant.holding_torque())
        self._sensors = Sensors(TIMESTEP, noise, seed)
        self._steps = self._command_ends = 0
        self._command: Array | None = None  # what the motors supply instead of control
        other = SIDES[1 - SIDES.index(side)]
        resting = Plant(other, description, truth, gravity=gravity)
        resting.place(Reference(other, 'hold').q)
        self._resting = Sensors(TIMESTEP, noise, seed + 1)
        self._resting_state = resting.q, resting.static_torque() + truth.bias
        simulated = joint_names(side) + joint_names(other)
        self._order = [simulated.index(name) if name in simulated else len(simulated)
                       for name in JOINT_STATE_NAMES]  # the head and the torso stay at zero
        self._sensors.read(self.plant.q, standing + truth.bias)
        self._resting.read(*self._resting_state)

    @property
    def time(self) -> float:
        """Time since the robot's start [s]."""
        return self._steps * TIMESTEP

    @property
    def force(self) -> Array:
        """Force on the moving hand, axes of the robot's base (3,) [N]; assign to it."""
        return self.plant.force

    @force.setter
    def force(self, value: ArrayLike) -> None:
        self.plant.force = np.array(value, dtype=float)

    @property
    def torque(self) -> Array:
        """External torque on the moving arm's joints (7,) [N m], s0 ... w2; assign to it."""
        return self.plant.torque

    @torque.setter
    def torque(self, value: ArrayLike) -> None:
        self.plant.torque = np.array(value, dtype=float)

    @property
    def is_commanded(self) -> bool:
        """Whether the motors obey torque commands now."""
        return self._command is not None

    def command(self, torque: ArrayLike) -> None:
        """
        Let the motors supply these torques and nothing else, as in the SDK's torque mode.

        They do until the next command, or for :data:`COMMAND_TIMEOUT`; then the robot's
        controller holds the arm where it is, beginning with the torques that it finds, and the
        trajectory is not taken up again. A joint faster than :data:`RUNAWAY` is braked at once.

        Parameters
        ----------
        torque : array_like (7,)
            Of the motors, s0 ... w2 [N m]: the effort that will be measured, but for bias and
            noise. Gravity and springs are not compensated beside it.

        Raises
        ------
        ArgumentError
            If it is not seven finite numbers, each within :data:`.plant.TORQUE_LIMIT`, or a
            joint runs away; what was commanded before then stays.

        """
        command = finite('torque', torque, (N_JOINTS,)).copy()
        beyond = np.flatnonzero(np.abs(command) > TORQUE_LIMIT)
        if len(beyond):
            joint = beyond[0]
            raise ArgumentError('torque', f'expected at most {TORQUE_LIMIT[joint]:g} N m at '
                                f'{JOINTS[joint]}, got {command[joint]:g}')
        if self._runs_away():
            joint = np.argmax(np.abs(self.plant.qd) / RUNAWAY)
            raise ArgumentError('torque', f'{JOINTS[joint]} runs away, and is braked first')
        self._command = command
        self._command_ends = self._steps + round(COMMAND_TIMEOUT / TIMESTEP)

    def advance(self, time: float) -> None:
        """Let the robot live until ``time`` [s since its start]."""
        while self.time < time - TIMESTEP / 2:
            if self._command is not None and (
                    self._steps >= self._command_ends or self._runs_away()):
                self._hold_here(self._command)
                self._command = None
            motor = self._control() if self._command is None else self._command
            self.plant.step(motor)
            self._sensors.read(self.plant.q, motor + self.plant.truth.bias)
            self._resting.read(*self._resting_state)
            self._steps += 1

    def joint_state(self) -> tuple[Array, Array, Array]:
        """Return position, velocity and effort, each (17,), in :data:`JOINT_STATE_NAMES`."""
        moving, still = self._sensors.publish(), self._resting.publish()
        position, velocity, effort = (
            np.concatenate([*pair, [0.0]])[self._order] for pair in zip(moving, still))
        return position, velocity, effort

    def _control(self) -> Array:
        """Return the motor torques (7,) [N m] that follow the reference."""
        ahead = -self._steps % _REFERENCE_STEPS
        if ahead == 0:
            self.reference.advance(_REFERENCE_STEPS * TIMESTEP)
            ahead = _REFERENCE_STEPS
        wanted = self.reference.q - ahead * TIMESTEP * self.reference.qd
        return self._controller.torque(
            wanted, self.reference.qd, self.plant.q, self.plant.qd,
            self.plant.holding_torque(), TIMESTEP)

    def _hold_here(self, motor: Array) -> None:
        """Make this place the reference, from motor torques (7,) [N m] on."""
        self.reference = Still(self.plant.q)
        if self._runs_away():
            self._controller = DoubleLoop()  # which does not go on with what drives it
        else:
            self._controller.start_at(
                motor, self.reference.q, self.reference.qd, self.plant.q, self.plant.qd,
                self.plant.holding_torque(), TIMESTEP)

    def _runs_away(self) -> bool:
        return bool((np.abs(self.plant.qd) > RUNAWAY).any())


def _reference(side: str, trajectory: str) -> Reference | Along:
    """Return the joint references along a trajectory."""
    if trajectory == 'exciting':
        return Excitation(side)
    if trajectory == 'poses':
        return Poses(side)
    return Reference(side, trajectory)

"""The fake Baxter: plant, controller and sensors put together; knows no ROS."""

import numpy as np

from .controller import DoubleLoop
from .excitation import Excitation
from .plant import default_truth
from .plant import Plant
from .plant import TIMESTEP
from .sensors import Sensors
from .trajectories import Reference
from ..core.effort import EffortModel
from ..core.exceptions import ArgumentError
from ..core.joints import joint_names
from ..core.joints import SIDES
from ..core.parameters import Payload

# The order in which the robot publishes: head, then each arm in alphabetical order, torso.
_ALPHABETICAL = ('e0', 'e1', 's0', 's1', 'w0', 'w1', 'w2')
JOINT_STATE_NAMES = (('head_nod', 'head_pan')
                     + tuple(f'{side}_{joint}' for side in ('left', 'right')
                             for joint in _ALPHABETICAL)
                     + ('torso_t0',))
GRIPPER_NAMES = ('r_gripper_l_finger_joint', 'r_gripper_r_finger_joint')
GRIPPER_RATE = 38.0  # [Hz]

TRAJECTORIES = ('circle', 'switch', 'lift', 'exciting', 'hold')

_REFERENCE_STEPS = 10  # time steps between two updates of the reference, a line between them


class FakeBaxter:
    """
    A Baxter whose one arm follows a trajectory while the other is held still.

    Parameters
    ----------
    side : str
        The arm that moves, 'right' or 'left'.
    trajectory : str
        One of :data:`TRAJECTORIES`: the paper's, the :mod:`.excitation`, or standing still.
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

    def __init__(self, side: str = 'right', trajectory: str = 'circle', description=None,
                 spring: bool = True, friction: bool = True, noise: bool = True, seed: int = 0,
                 truth: EffortModel = None, payload: Payload = None, gravity=None):
        if trajectory not in TRAJECTORIES:
            raise ArgumentError('trajectory', f'expected one of {", ".join(TRAJECTORIES)}, '
                                f'got {trajectory!r}')
        if truth is None:
            truth = default_truth(spring, friction)
        elif not (spring and friction):
            raise ArgumentError('truth', 'says what spring and friction there are: leave the '
                                'arguments spring and friction out')
        self.plant = Plant(side, description, truth, payload, gravity)
        self.reference = (Excitation(side) if trajectory == 'exciting'
                          else Reference(side, trajectory))
        self.plant.place(self.reference.q)
        standing = self.plant.static_torque()
        self._controller = DoubleLoop(standing - self.plant.holding_torque())
        self._sensors = Sensors(TIMESTEP, noise, seed)
        self._steps = 0
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
    def force(self) -> np.ndarray:
        """Force on the moving hand, axes of the robot's base (3,) [N]; assign to it."""
        return self.plant.force

    @force.setter
    def force(self, value):
        self.plant.force = np.array(value, dtype=float)

    @property
    def torque(self) -> np.ndarray:
        """External torque on the moving arm's joints (7,) [N m], s0 ... w2; assign to it."""
        return self.plant.torque

    @torque.setter
    def torque(self, value):
        self.plant.torque = np.array(value, dtype=float)

    def advance(self, time: float):
        """Let the robot live until ``time`` [s since its start]."""
        while self.time < time - TIMESTEP / 2:
            ahead = -self._steps % _REFERENCE_STEPS
            if ahead == 0:
                self.reference.advance(_REFERENCE_STEPS * TIMESTEP)
                ahead = _REFERENCE_STEPS
            wanted = self.reference.q - ahead * TIMESTEP * self.reference.qd
            motor = self._controller.torque(
                wanted, self.reference.qd, self.plant.q, self.plant.qd,
                self.plant.holding_torque(), TIMESTEP)
            self.plant.step(motor)
            self._sensors.read(self.plant.q, motor + self.plant.truth.bias)
            self._resting.read(*self._resting_state)
            self._steps += 1

    def joint_state(self) -> tuple:
        """Return position, velocity and effort, each (17,), in :data:`JOINT_STATE_NAMES`."""
        moving, still = self._sensors.publish(), self._resting.publish()
        return tuple(np.concatenate([*pair, [0.0]])[self._order] for pair in zip(moving, still))

"""What each of the model's two corrections is worth, against the manufacturer's description."""

from __future__ import annotations

from typing import NamedTuple

from baxter_dynamics_ros import BaxterArm, JOINTS, mount
from baxter_dynamics_ros.model.composite import CompositeDynamics
from baxter_dynamics_ros.model.joints import N_JOINTS, POSITION_LOWER, POSITION_UPPER
from baxter_dynamics_ros.model.paper_tables import GRAVITY
from baxter_dynamics_ros.model.parameters import (CORRECTIONS, inertia_about_origin,
                                                  INERTIA_AT_ORIGIN, paper_parameters,
                                                  pseudo_inertia_as_printed, THETA_2_OFFSET)
from baxter_dynamics_ros.newton_euler import NewtonEuler
from baxter_dynamics_ros.simulation.description import arm_description
import numpy as np
import pinocchio as pin

SIDE = 'right'
# Which corrections are applied, by what the table calls it.
VARIANTS = {
    'as printed': frozenset(),
    'inertias moved': frozenset({INERTIA_AT_ORIGIN}),
    'pi/2 at theta_2': frozenset({THETA_2_OFFSET}),
    'both': CORRECTIONS,
}

_SIGNS = 'both, but +I_xy'  # a row of the table: the off-diagonals of eq. (12) as printed
_STATES = 2000
_SPEED = 1.5  # [rad/s]
_ACCELERATION = 2.5  # [rad/s^2]


class Manufacturer:
    """The manufacturer's arm in Pinocchio: neither our numbers nor our code."""

    def __init__(self) -> None:
        self._model = pin.buildModelFromXML(arm_description(SIDE))
        self._data = self._model.createData()
        self._hand = self._model.getFrameId(f'{SIDE}_hand_link')

    def inverse_dynamics(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Return tau (n, 7) [N m] of states (n, 7)."""
        return np.array([pin.rnea(self._model, self._data, *state).copy()
                         for state in zip(q, qd, qdd)])

    def places(self, q: np.ndarray) -> np.ndarray:
        """Return where joints s0 to w2 and the hand are for q (7,), (8, 3) in the base [m]."""
        pin.framesForwardKinematics(self._model, self._data, q)
        return np.array([*(joint.translation for joint in list(self._data.oMi)[1:]),
                         self._data.oMf[self._hand].translation])


class Evidence(NamedTuple):
    """What the corrections are worth; errors are ours less the manufacturer's."""

    rms: dict[str, np.ndarray]  # variant -> RMS of the torque's error (7,) [N m]
    most: np.ndarray  # greatest error with both corrections (7,) [N m]
    exactness: float  # greatest difference to Pinocchio on the same numbers [N m]
    hand: dict[str, float]  # variant -> greatest error of the hand's place [m]
    eigenvalue: dict[str, float]  # variant -> least eigenvalue of all J_i
    mass_matrix: float  # greatest error of M by the printed inertias [kg m^2]


def variant(name: str) -> BaxterArm:
    """Return the arm of one of VARIANTS."""
    return BaxterArm(mount=mount(SIDE), parameters=paper_parameters(VARIANTS[name]))


def collect() -> Evidence:
    """Compare on random states within the joints' limits."""
    random = np.random.default_rng(0)
    shape = _STATES, N_JOINTS
    q = random.uniform(POSITION_LOWER, POSITION_UPPER, shape)
    qd = random.uniform(-_SPEED, _SPEED, shape)
    qdd = random.uniform(-_ACCELERATION, _ACCELERATION, shape)
    manufacturer = Manufacturer()
    torques = manufacturer.inverse_dynamics(q, qd, qdd)
    hands = np.array([manufacturer.places(row)[-1] for row in q])
    arms = {name: variant(name) for name in VARIANTS}
    errors = {name: arm.inverse_dynamics(q, qd, qdd) - torques for name, arm in arms.items()}
    errors[_SIGNS] = _signs_as_printed().inverse_dynamics(q, qd, qdd) - torques
    both, printed_inertias = arms['both'], arms['pi/2 at theta_2']
    recursive = NewtonEuler(both).inverse_dynamics(q, qd, qdd)
    return Evidence(
        rms={name: np.sqrt(np.mean(error ** 2, axis=0)) for name, error in errors.items()},
        most=np.abs(errors['both']).max(axis=0),
        exactness=float(np.abs(both.inverse_dynamics(q, qd, qdd) - recursive).max()),
        hand={name: float(np.linalg.norm(
            arm.forward_kinematics(q)[:, :3, 3] - hands, axis=-1).max())
            for name, arm in arms.items()},
        eigenvalue={name: float(np.linalg.eigvalsh(arm.parameters.pseudo_inertia).min())
                    for name, arm in arms.items()},
        mass_matrix=float(np.abs(printed_inertias.mass_matrix(q) - both.mass_matrix(q)).max()))


def _signs_as_printed() -> CompositeDynamics:
    """Return the corrected model with the off-diagonals of eq. (12) as printed."""
    p = paper_parameters()
    moved = inertia_about_origin(p.inertia, p.mass, p.center_of_mass)
    return CompositeDynamics(
        p, pseudo_inertia_as_printed(moved, p.mass, p.center_of_mass), np.array(GRAVITY))


def table() -> str:
    """Return the evidence as text."""
    found = collect()
    width = max(map(len, VARIANTS))
    lines = [f"error of tau against the manufacturer's description, RMS over {_STATES} states",
             f'[N m]; |qd| <= {_SPEED:g} rad/s, |qdd| <= {_ACCELERATION:g} rad/s^2',
             ' ' * width + ''.join(f'{joint:>9}' for joint in JOINTS)]
    lines += [f'{name:{width}}' + ''.join(f'{x:9.4f}' for x in rms)
              for name, rms in found.rms.items()]
    lines += [f'{"both, most":{width}}' + ''.join(f'{x:9.4f}' for x in found.most),
              '',
              f'{"":{width}}  hand off by, most [m]  least eigenvalue of J']
    lines += [f'{name:{width}}  {found.hand[name]:21.5f}  {found.eigenvalue[name]:21.5f}'
              for name in VARIANTS]
    return '\n'.join([
        *lines, '',
        f'M by the printed inertias is off by up to {found.mass_matrix:.3f} kg m^2',
        f'from Pinocchio on the same numbers tau differs by {found.exactness:.0e} N m at most'])

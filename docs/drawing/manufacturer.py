"""The arm of the manufacturer's description, and the paper's with and without corrections."""

from __future__ import annotations

from baxter_dynamics_ros import BaxterArm, mount
from baxter_dynamics_ros.model.parameters import CORRECTIONS, paper_parameters, THETA_2_OFFSET
from baxter_dynamics_ros.simulation.description import arm_description
import numpy as np
import pinocchio as pin

SIDE = 'right'
VARIANTS = {
    'as printed': frozenset(),
    'pi/2 at theta_2': frozenset({THETA_2_OFFSET}),
    'both': CORRECTIONS,
}


class Manufacturer:
    """The manufacturer's arm in Pinocchio, independent of this package."""

    def __init__(self) -> None:
        self._model = pin.buildModelFromXML(arm_description(SIDE))
        self._data = self._model.createData()
        self._hand = self._model.getFrameId(f'{SIDE}_hand_link')

    def inverse_dynamics(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        """Return tau (n, 7) [N m] of states (n, 7)."""
        return np.array([pin.rnea(self._model, self._data, *state).copy()
                         for state in zip(q, qd, qdd)])

    def places(self, q: np.ndarray) -> np.ndarray:
        """Return the positions of joints s0 to w2 and of the hand for q (7,), (8, 3) [m]."""
        pin.framesForwardKinematics(self._model, self._data, q)
        return np.array([*(joint.translation for joint in list(self._data.oMi)[1:]),
                         self._data.oMf[self._hand].translation])


def variant(name: str) -> BaxterArm:
    """Return the arm of one of VARIANTS."""
    return BaxterArm(mount=mount(SIDE), parameters=paper_parameters(VARIANTS[name]))

"""Model of an arm, as the predictor uses it."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..model.arm import BaxterArm
from ..model.arrays import Array
from ..model.effort import EffortModel
from ..model.joints import N_JOINTS


class ArmModel(NamedTuple):
    """Rigid-body model and effort model of an arm; methods take validated arrays."""

    arm: BaxterArm  # in the robot's base frame
    effort_model: EffortModel  # from tau to measured effort
    # (q, qd, qdd), (..., 7) each -> tau (..., 7) [N m].
    inverse_dynamics: Callable[[Array, Array, Array], Array]

    def momentum_terms(self, q: Array, qd: Array) -> tuple[Array, Array, Array]:
        """
        Return the momentum [N m s], C^T qd and G [N m], (7,) each, of the state q, qd (7,).

        The momentum includes the added inertia of the effort model: its contribution to the effort
        is the time derivative of its contribution to the momentum.
        """
        momentum, coriolis, gravity = self.arm.momentum_terms(q, qd)
        return momentum + self.effort_model.added_inertia * qd, coriolis, gravity

    def warm_up(self) -> None:
        """Call each function once, so that lazy imports do not delay the first message."""
        q, qd, qdd = np.zeros((3, N_JOINTS))
        self.inverse_dynamics(q, qd, qdd)
        self.momentum_terms(q, qd)
        self.arm.gravity(q)
        self.arm.terms(q, qd)

"""What a stream needs of the model of an arm, validated beforehand."""

from typing import Callable
from typing import NamedTuple

import numpy as np

from ..core.effort import EffortModel


class ArmModel(NamedTuple):
    """The model of an arm as functions of one state, or of several stacked where it says (...)."""

    inverse_dynamics: Callable  # of q, qd, qdd, (..., 7) each: tau (..., 7) [N m]
    links_momentum: Callable  # of q, qd, (7,) each: M qd [N m s], C^T qd and G [N m], (7,) each
    jacobian: Callable  # of q (7,): that of the hand in the base frame (6, 7)
    effort_model: EffortModel  # from tau to measured effort

    def momentum_terms(self, q: np.ndarray, qd: np.ndarray) -> tuple:
        """
        Return the momentum [N m s], C^T qd and G [N m], (7,) each, of the state q, qd (7,).

        The inertia that the measured effort shows beyond the links' is part of the momentum, for
        what it adds to the effort is the derivative of what it adds to that.
        """
        terms = self.links_momentum(q, qd)
        if not self.effort_model.has_added_inertia:
            return terms
        momentum, coriolis, gravity = terms
        return momentum + self.effort_model.added_inertia * qd, coriolis, gravity

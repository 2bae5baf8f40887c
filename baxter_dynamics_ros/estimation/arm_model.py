"""What a stream needs of the model of an arm, validated beforehand."""

from collections.abc import Callable
from typing import NamedTuple

from ..model.arrays import Array
from ..model.effort import EffortModel


class ArmModel(NamedTuple):
    """The model of an arm as functions of one state, or of several stacked where it says (...)."""

    # Of q, qd, qdd, (..., 7) each: tau (..., 7) [N m].
    inverse_dynamics: Callable[[Array, Array, Array], Array]
    # Of q, qd, (7,) each: M qd [N m s], C^T qd and G [N m], (7,) each.
    links_momentum: Callable[[Array, Array], tuple[Array, Array, Array]]
    # Of q (7,): that of the hand in the base frame (6, 7).
    jacobian: Callable[[Array], Array]
    effort_model: EffortModel  # from tau to measured effort

    def momentum_terms(self, q: Array, qd: Array) -> tuple[Array, Array, Array]:
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

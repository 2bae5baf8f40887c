"""Arm model as functions of validated arrays, for the stream handler."""

from collections.abc import Callable
from typing import NamedTuple

from ..model.arrays import Array
from ..model.effort import EffortModel


class ArmModel(NamedTuple):
    """Functions of one validated state; those with shapes (..., 7) also accept a batch."""

    # (q, qd, qdd), (..., 7) each -> tau (..., 7) [N m].
    inverse_dynamics: Callable[[Array, Array, Array], Array]
    # (q, qd), (7,) each -> M qd [N m s], C^T qd and G [N m], (7,) each.
    links_momentum: Callable[[Array, Array], tuple[Array, Array, Array]]
    # q (7,) -> Jacobian of the hand in the base frame (6, 7).
    jacobian: Callable[[Array], Array]
    effort_model: EffortModel  # from tau to measured effort

    def momentum_terms(self, q: Array, qd: Array) -> tuple[Array, Array, Array]:
        """
        Return the momentum [N m s], C^T qd and G [N m], (7,) each, of the state q, qd (7,).

        The momentum includes the added inertia of the effort model: its contribution to the effort
        is the time derivative of its contribution to the momentum.
        """
        momentum, coriolis, gravity = self.links_momentum(q, qd)
        return momentum + self.effort_model.added_inertia * qd, coriolis, gravity

"""BaxterArm with numba: as it is used, the engine inside it, and the compiled function alone."""

from baxter_dynamics_ros import BaxterArm, compiled
import numpy as np

from .engine import Engine
from .ours import pair


def engines(arm) -> list:
    """Return the calls of BaxterArm, those inside it, and the function that they end in."""
    arm = BaxterArm(parameters=arm.parameters, gravity=arm.gravity_vector, engine='numba')
    constants, out = np.array(arm.dynamics.constants), np.empty(7)
    function = compiled.MODULE.inverse_dynamics_upright_row

    def tau(q, qd, qdd):
        function(q, qd, qdd, constants, out)
        return out

    alone = Engine('ours, numba, bare', tau=tau, notes={'tau': 'the compiled function'})
    return [*pair('ours, numba', arm), alone]

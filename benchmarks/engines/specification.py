"""Our equations (5) to (11) as the paper prints them: what everything else is compared with."""

from baxter_dynamics_ros.model import lagrange_euler

from .engine import Engine


def engines(arm) -> list:
    """Return the specification, term by term."""
    parameters, gravity = arm.parameters, arm.gravity_vector

    def tau(q, qd, qdd):
        return lagrange_euler.inverse_dynamics(parameters, q, qd, qdd, gravity)

    return [Engine(name='ours, equations as printed', tau=tau,
                   notes={'tau': 'model/lagrange_euler.py: what all others must agree with'})]

"""Nothing is timed that does not agree with the equations as printed."""

from baxter_dynamics_ros.model import joints, lagrange_euler
import numpy as np


def random_states(n: int) -> tuple:
    """Return n states q, qd, qdd, each (n, 7), within the arm's limits; the same every time."""
    rng = np.random.default_rng(20)
    return (rng.uniform(joints.POSITION_LOWER, joints.POSITION_UPPER, (n, joints.N_JOINTS)),
            rng.uniform(-1.0, 1.0, (n, joints.N_JOINTS)) * joints.VELOCITY_LIMIT,
            rng.uniform(-5.0, 5.0, (n, joints.N_JOINTS)))  # [rad/s^2]


class Reference:
    """
    The specification's answers for some states.

    Parameters
    ----------
    arm : BaxterArm
        Whose parameters and gravity to use.
    n : int
        How many states.

    """

    def __init__(self, arm, n: int):
        parameters, gravity = arm.parameters, arm.gravity_vector
        self.states = self.q, self.qd, self.qdd = random_states(n)
        self.mass = lagrange_euler.mass_matrix(parameters, self.q)
        self.coriolis = lagrange_euler.coriolis_matrix(parameters, self.q, self.qd)
        self.gravity = lagrange_euler.gravity(parameters, self.q, gravity)
        self.centrifugal = (self.coriolis @ self.qd[..., None])[..., 0]  # C qd
        self.tau = self._torque(self.qdd)

    def differences(self, engine) -> dict:
        """Return the largest difference in torque [N m] for each call that the engine has."""
        checks = {'tau': self._tau, 'split': self._split,
                  'matrices': self._matrices, 'forward': self._forward, 'batch': self._batch}
        return {call: float(check(engine)) for call, check in checks.items()
                if getattr(engine, call) is not None}

    def _tau(self, engine):
        return max(np.abs(np.asarray(engine.tau(*state)).ravel() - tau).max()
                   for state, tau in zip(zip(*self.states), self.tau))

    def _batch(self, engine):
        return np.abs(np.asarray(engine.batch(*self.states)) - self.tau).max()

    def _split(self, engine):
        return max(self._distance(k, mass, np.ravel(centrifugal) - self.centrifugal[k], gravity)
                   for k, (mass, centrifugal, gravity) in self._each(engine.split))

    def _matrices(self, engine):
        return max(self._distance(k, mass, (coriolis - self.coriolis[k]) @ self.qd[k], gravity)
                   for k, (mass, coriolis, gravity) in self._each(engine.matrices))

    def _forward(self, engine):
        qdd = [np.array(engine.forward(*state))
               for state in zip(self.q, self.qd, self.tau)]
        return np.abs(self._torque(np.array(qdd)) - self.tau).max()

    def _each(self, call):
        for k, state in enumerate(zip(self.q, self.qd)):
            yield k, call(*state)

    def _distance(self, k, mass, centrifugal_error, gravity):
        """Return the largest error that one of the three terms makes in a torque."""
        # crba promises its upper triangle only.
        error = np.triu(np.asarray(mass) - self.mass[k])
        error = error + np.triu(error, 1).T
        return max(np.abs(error @ self.qdd[k]).max(), np.abs(centrifugal_error).max(),
                   np.abs(np.ravel(gravity) - self.gravity[k]).max())

    def _torque(self, qdd):
        return (self.mass @ qdd[..., None])[..., 0] + self.centrifugal + self.gravity

"""Pinocchio as a reference: the quantities by the names that ours have."""

import numpy as np


class PinocchioEngine:
    """Pinocchio's answers for batches (n, 7) of states; it takes one at a time itself."""

    def __init__(self, pin, model, hand):
        self._pin = pin
        self._model = model
        self._data = model.createData()
        self._hand = model.getFrameId(hand)

    def mass_matrix(self, q):
        """Return M (n, 7, 7); crba promises its upper triangle only."""
        upper = np.triu(self._each(self._pin.crba, q))
        return upper + np.swapaxes(np.triu(upper, 1), -1, -2)

    def coriolis_matrix(self, q, qd):
        """Return C (n, 7, 7), which Pinocchio too takes from the Christoffel symbols."""
        return self._each(self._pin.computeCoriolisMatrix, q, qd)

    def gravity(self, q):
        """Return G (n, 7)."""
        return self._each(self._pin.computeGeneralizedGravity, q)

    def inverse_dynamics(self, q, qd, qdd):
        """Return tau (n, 7), by the recursive Newton-Euler algorithm."""
        return self._each(self._pin.rnea, q, qd, qdd)

    def coriolis_torque(self, q, qd):
        """Return C qd (n, 7), by the recursive Newton-Euler algorithm."""
        return self._each(self._pin.nonLinearEffects, q, qd) - self.gravity(q)

    def inverse_dynamics_gradient(self, q, qd, qdd):
        """Return d tau/dq and d tau/dqd, each (n, 7, 7)."""
        both = [[x.copy() for x in self._pin.computeRNEADerivatives(self._model, self._data, *row)]
                for row in zip(q, qd, qdd)]
        return np.array([x[0] for x in both]), np.array([x[1] for x in both])

    def forward_dynamics(self, q, qd, tau):
        """Return qdd (n, 7), by the articulated-body algorithm."""
        return self._each(self._pin.aba, q, qd, tau)

    def forward_kinematics(self, q):
        """Return poses of the hand (n, 4, 4)."""
        return self._each(self._pose, q)

    def jacobian(self, q):
        """Return Jacobians of the hand (n, 6, 7), linear rows first, with base-frame axes."""
        return self._each(self._pin.computeFrameJacobian, q, after=(
            self._hand, self._pin.ReferenceFrame.LOCAL_WORLD_ALIGNED))

    def _pose(self, model, data, q):
        self._pin.framesForwardKinematics(model, data, q)
        return data.oMf[self._hand].homogeneous

    def _each(self, function, *arrays, after=()):
        return np.array([function(self._model, self._data, *row, *after).copy()
                         for row in zip(*arrays)])

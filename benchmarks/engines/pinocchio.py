"""Pinocchio: the recursive Newton-Euler method and its companions."""

from functools import partial

from baxter_dynamics_ros.newton_euler import NewtonEuler
import numpy as np
import pinocchio as pin

from .engine import Engine


def engines(arm) -> list:
    """Return Pinocchio's calls on the model that the tests use."""
    reference = NewtonEuler(arm)
    model, data = reference.model, reference.data
    crba, coriolis, bias, gravity = (partial(function, model, data) for function in (
        pin.crba, pin.computeCoriolisMatrix, pin.nonLinearEffects, pin.computeGeneralizedGravity))

    def split(q, qd):
        # The results alias data: nonLinearEffects leaves that of computeGeneralizedGravity alone.
        mass, holding = crba(q), gravity(q)
        return mass, bias(q, qd) - holding, holding

    def matrices(q, qd):
        return crba(q), coriolis(q, qd), gravity(q)

    return [Engine(
        name='Pinocchio', tau=partial(pin.rnea, model, data), split=split, matrices=matrices,
        forward=partial(pin.aba, model, data), batch=_batch(model),
        notes={'tau': 'rnea', 'batch': 'rneaInParallel', 'forward': 'aba',
               'split': 'crba, nonLinearEffects, computeGeneralizedGravity',
               'matrices': 'crba, computeCoriolisMatrix, computeGeneralizedGravity'})]


def _batch(model):
    """Return rneaInParallel on one thread; only a Pinocchio built with OpenMP has it."""
    if not hasattr(pin, 'rneaInParallel'):
        return None
    pool, results = pin.ModelPool(model, 1), {}

    def batch(q, qd, qdd):
        tau = results.get(q.shape)
        if tau is None:
            tau = results[q.shape] = np.empty(q.shape)
        pin.rneaInParallel(1, pool, q.T, qd.T, qdd.T, tau.T)
        return tau

    return batch

"""Identifiability of parameters: comparison of posterior and prior uncertainty."""

import numpy as np

from .fit_data import Motion
from .normal import information, NormalEquations, Regressor
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS

MOVES = 0.05  # minimum speed of a moving joint [rad/s]

_UNKNOWN = 0.7  # ratio of posterior to prior deviation above which a parameter is unidentifiable


def turning(motions: list[Motion]) -> Bools:
    """Return the joints whose positions move in both directions, (7,) bool."""
    speed = np.concatenate([motion.speed for motion in motions])
    return (speed.max(0) > MOVES) & (speed.min(0) < -MOVES)


def unknown(regressor: Regressor, normal: NormalEquations, weights: Array,
            turning: Bools) -> tuple[Bools, dict[int, list[str]]]:
    """
    Find the parameters of each joint that are unidentifiable even when fitted with the bias alone.

    This includes the parameters of joints that do not reverse.

    Parameters
    ----------
    regressor : Regressor
        All terms.
    normal : NormalEquations
        Sums over all data.
    weights : ndarray (7,)
        1 / variance of each joint's residual [1/(N m)^2].
    turning : ndarray (7,) of bool
        Joints that reverse.

    Returns
    -------
    tuple (ndarray (p,) of bool, dict)
        Unidentifiable parameters, and joint index -> names of their terms.

    """
    parameters = regressor.parameters
    mask = np.zeros(len(parameters), dtype=bool)
    lost: dict[int, list[str]] = {}
    own = [(term, where) for term, where in zip(regressor.terms, regressor.slices)
           if not term.shared]
    bias = [where.start for term, where in own if term.name == 'bias']
    for term, where in own:
        if term.name == 'bias':
            continue
        for joint in range(N_JOINTS):
            for k in where.start + np.array(term.acting(joint), dtype=int):
                active = np.zeros(len(parameters), dtype=bool)
                active[[k, *(start + joint for start in bias)]] = True
                inverse = np.linalg.inv(information(normal, weights, parameters, active))
                variance = np.diag(inverse)[np.flatnonzero(active) == k].item()
                if not turning[joint] or np.sqrt(variance) > _UNKNOWN * parameters[k].prior:
                    mask[k] = True
                    if term.name not in lost.setdefault(joint, []):
                        lost[joint].append(term.name)
    return mask, lost

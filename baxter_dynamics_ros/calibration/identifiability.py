"""Identifiability: parameters that the motion leaves as uncertain as they were before."""

import numpy as np

from .fit_data import Motion
from .normal import information, NormalEquations, Regressor
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS

MOVES = 0.05  # a joint that never exceeds this speed does not move [rad/s]

_UNKNOWN = 0.7  # share of the prior's uncertainty that is left, above which nothing was learnt


def turning(motions: list[Motion]) -> Bools:
    """Return which joints move in both directions, judged by positions, (7,) bool."""
    speed = np.concatenate([motion.speed for motion in motions])
    return (speed.max(0) > MOVES) & (speed.min(0) < -MOVES)


def unknown(regressor: Regressor, normal: NormalEquations, weights: Array,
            turning: Bools) -> tuple[Bools, dict[int, list[str]]]:
    """
    Find the unidentifiable parameters of each joint, even alone beside the bias.

    Those of a joint that does not turn round are among them: noise would be fitted to noise.

    Parameters
    ----------
    regressor : Regressor
        All terms.
    normal : NormalEquations
        Of all the data.
    weights : ndarray (7,)
        1 / variance of each joint's residual [1/(N m)^2].
    turning : ndarray (7,) of bool
        Which joints turn round.

    Returns
    -------
    tuple (ndarray (p,) of bool, dict)
        Which, and index of a joint -> names of the terms.

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

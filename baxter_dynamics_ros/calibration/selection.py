"""Selection of terms by cross-validation."""

from collections.abc import Collection, Iterable, Iterator, Sequence

import numpy as np

from .calibration_results import Selection
from .normal import NormalEquations, Regressor, solve
from .term import Term
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS


class LeftOut:
    """
    Cross-validation: fits without each fold in turn, evaluated on that fold.

    Parameters
    ----------
    regressor : Regressor
        The terms.
    folds : list of NormalEquations
        Sums over each recording, or over each part of one.

    """

    def __init__(self, regressor: Regressor, folds: list[NormalEquations]) -> None:
        self._regressor = regressor
        self._folds = folds
        self.whole = sum(folds[1:], folds[0])
        self._others = [self.whole - fold for fold in folds]

    def squared_error(self, weights: Array, active: Bools, joints: Iterable[int]) -> Array:
        """Return the left-out sum of squared residuals (7,) of some joints, fitted together."""
        chosen = np.zeros(N_JOINTS)
        chosen[list(joints)] = weights[list(joints)]
        fits = [solve(other, chosen, self._regressor.parameters, active) for other in self._others]
        return sum((fold.squared_error(b) for fold, b in zip(self._folds, fits)),
                   np.zeros(N_JOINTS))

    def rms(self, squared_error: Array) -> Array:
        """Return the RMS (7,) [N m] of a sum of squared residuals."""
        return np.sqrt(squared_error / self.whole.count)


def select(regressor: Regressor, folds: list[NormalEquations], weights: Array,
           wanted: Collection[str], unknown: Bools) -> list[Selection]:
    """
    Select the terms that improve the cross-validated residual.

    Parameters
    ----------
    regressor : Regressor
        All terms, in the order in which they are tried.
    folds : list of NormalEquations
        Of recordings, or parts of one.
    weights : ndarray (7,)
        1 / variance of each joint's residual [1/(N m)^2].
    wanted : collection of str
        Names of terms that are always fitted.
    unknown : ndarray (p,) of bool
        Unidentifiable parameters, which are not fitted.

    Returns
    -------
    list of Selection
        The first has no term.

    """
    left_out = LeftOut(regressor, folds)
    active = np.zeros(len(regressor.parameters), dtype=bool)
    error = left_out.whole.square.copy()
    steps = [Selection('', (), left_out.rms(error), active.copy())]
    shared = False
    for term, where in _in_turn(regressor, left_out, weights, active):
        trial = active.copy()
        trial[where] = True
        if term.shared:
            new = left_out.squared_error(weights, trial, range(N_JOINTS))
            pays = np.mean(np.log(new / error)) < 2 * np.log1p(-term.worth)
            kept = tuple(range(N_JOINTS)) if pays or term.name in wanted else ()
            if kept:
                active[where] = True
                error = new
                shared = True
        else:
            kept = ()
            for joint in range(N_JOINTS):
                own = where.start + np.array(term.acting(joint), dtype=int)
                own = own[~unknown[own]]
                if not len(own):
                    continue
                trial = active.copy()
                trial[own] = True
                together: Sequence[int] = range(N_JOINTS)
                if not shared:  # then the joints do not depend on each other
                    trial &= _acts_on(regressor, joint)
                    together = [joint]
                new = left_out.squared_error(weights, trial, together)[joint]
                if new < error[joint] * (1 - term.worth) ** 2 or term.name in wanted:
                    active[own] = True
                    error[joint] = new
                    kept += (joint,)
        steps.append(Selection(term.name, kept, left_out.rms(error), active.copy()))
    return steps


def _in_turn(regressor: Regressor, left_out: LeftOut, weights: Array,
             active: Bools) -> Iterator[tuple[Term, slice]]:
    """Yield the terms and their slices; of the Dahl terms only the one with the best length."""
    tried = set()
    for term, where in zip(regressor.terms, regressor.slices):
        if term.name in tried:
            continue
        tried.add(term.name)
        same = [pair for pair in zip(regressor.terms, regressor.slices)
                if pair[0].name == term.name]
        if len(same) > 1:
            scores = []
            for _, candidate in same:
                trial = active.copy()
                trial[candidate] = True
                scores.append(sum(
                    np.log(left_out.squared_error(
                        weights, trial & _acts_on(regressor, joint), [joint])[joint])
                    for joint in range(N_JOINTS)))
            term, where = same[int(np.argmin(scores))]
        yield term, where


def _acts_on(regressor: Regressor, joint: int) -> Bools:
    mask = np.zeros(len(regressor.parameters), dtype=bool)
    mask[regressor.acting(joint)] = True
    return mask

"""Selection of terms: what the motion shows, and what improves the cross-validated residual."""

from collections.abc import Collection, Iterable, Iterator
from itertools import groupby

import numpy as np

from .calibration_results import Selection
from .fit_data import turning
from .normal import information, Problem, solve
from .term import Term
from ..model.arrays import Array, Bools, Indices
from ..model.joints import N_JOINTS

_UNKNOWN = 0.7  # ratio of posterior to prior deviation above which a parameter is unidentifiable


def unidentifiable(problem: Problem, weights: Array) -> tuple[Bools, dict[int, list[str]]]:
    """
    Find the parameters of single joints that the data do not show, even fitted with bias alone.

    This includes all of joints that do not reverse. Returned are the parameters, (p,) bool, and
    the names of their terms by joint.
    """
    prior = problem.regressor.prior
    reverses = turning(problem.motions)
    mask = problem.none()
    lost: dict[int, list[str]] = {}
    bias = [where.start for term, where in problem.terms if term.name == 'bias']
    for term, where in problem.terms:
        if term.shared or term.name == 'bias':
            continue
        for joint in range(N_JOINTS):
            for k in _own(term, where, joint).tolist():
                active = problem.none()
                active[[k, *(start + joint for start in bias)]] = True
                inverse = np.linalg.inv(information(problem.whole, weights, prior, active))
                variance = np.diag(inverse)[np.flatnonzero(active) == k].item()
                if not reverses[joint] or np.sqrt(variance) > _UNKNOWN * prior.deviation[k]:
                    mask[k] = True
                    if term.name not in lost.setdefault(joint, []):
                        lost[joint].append(term.name)
    return mask, lost


class CrossValidation:
    """Fits without each fold in turn, evaluated on that fold."""

    def __init__(self, problem: Problem, weights: Array) -> None:
        self._problem = problem
        self._weights = weights  # (7,) 1 / variance of each joint's residual [1/(N m)^2]
        self._others = [problem.whole - fold for fold in problem.folds]

    def squared_error(self, active: Bools, joints: Iterable[int]) -> Array:
        """Return the left-out sum of squared residuals (7,) of some joints, fitted together."""
        weights = np.zeros(N_JOINTS)
        weights[list(joints)] = self._weights[list(joints)]
        regressor = self._problem.regressor
        active = active & regressor.acts[weights > 0.0].any(0)
        return sum((fold.squared_error(solve(other, weights, regressor.prior, active))
                    for fold, other in zip(self._problem.folds, self._others)),
                   np.zeros(N_JOINTS))


def select(problem: Problem, weights: Array, wanted: Collection[str],
           unknown: Bools) -> list[Selection]:
    """
    Select the terms that improve the cross-validated residual, in the order of the problem.

    Terms named in ``wanted`` are always fitted, ``unknown`` parameters, (p,) bool, never. The
    first step has no term.
    """
    left_out = CrossValidation(problem, weights)
    active = problem.none()
    error = problem.whole.square.copy()
    steps = [Selection('', (), np.sqrt(error / problem.whole.count), active.copy())]
    coupled = False  # whether a term that all joints share is fitted
    for term, where in _best_alternatives(problem, left_out, active):
        kept: list[int] = []
        for joints, own in _parts(term, where):
            own = own[~unknown[own]]
            if not len(own):
                continue
            trial = active.copy()
            trial[own] = True
            together = range(N_JOINTS) if coupled or term.shared else joints
            new = left_out.squared_error(trial, together)[joints]
            ratio = np.maximum(new, 1e-12) / np.maximum(error[joints], 1e-12)
            if np.log(ratio).mean() < 2 * np.log1p(-term.worth) or term.name in wanted:
                active[own] = True
                error[joints] = new
                kept += joints
        coupled |= term.shared and bool(kept)
        steps.append(Selection(term.name, tuple(kept), np.sqrt(error / problem.whole.count),
                               active.copy()))
    return steps


def _parts(term: Term, where: slice) -> Iterator[tuple[list[int], Indices]]:
    """Yield the joints and parameters that are selected together."""
    if term.shared:
        yield list(range(N_JOINTS)), np.arange(where.start, where.stop)
    else:
        yield from (([joint], _own(term, where, joint)) for joint in range(N_JOINTS))


def _own(term: Term, where: slice, joint: int) -> Indices:
    return where.start + np.flatnonzero(term.acts[joint])


def _best_alternatives(problem: Problem, left_out: CrossValidation,
                       active: Bools) -> Iterator[tuple[Term, slice]]:
    """Yield the terms and their slices; of the Dahl terms only the one with the best length."""
    for _, group in groupby(problem.terms, lambda pair: pair[0].name):
        alternatives = list(group)
        scores = []
        for _, where in alternatives if len(alternatives) > 1 else []:
            trial = active.copy()
            trial[where] = True
            scores.append(sum(np.log(left_out.squared_error(trial, [joint])[joint])
                              for joint in range(N_JOINTS)))
        yield alternatives[int(np.argmin(scores)) if scores else 0]

"""Selection of terms: what the motion shows, and what improves the cross-validated residual."""

from collections.abc import Collection, Iterable, Iterator
from itertools import groupby

import numpy as np

from .calibration_results import Selection
from .fit_data import turning
from .normal import information, NormalEquations, Problem, solve
from .term import Term
from ..model.arrays import Array, Bools, Indices
from ..model.joints import N_JOINTS

_UNKNOWN = 0.7  # ratio of posterior to prior deviation above which a parameter is unidentifiable
_MOST = 0.7  # share of the folds in which a parameter selected by itself must help


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
                    if not term.separate and term.name not in lost.setdefault(joint, []):
                        lost[joint].append(term.name)
    return mask, lost


class CrossValidation:
    """Fits without each fold in turn, evaluated on that fold."""

    def __init__(self, problem: Problem, weights: Array) -> None:
        self._problem = problem
        self._weights = weights  # (7,) 1 / variance of each joint's residual [1/(N m)^2]
        self._others = [problem.whole - fold for fold in problem.folds]

    def fit(self, normal: NormalEquations, active: Bools, joints: Iterable[int]) -> Array:
        """Return the deviations (p,) for some sums, with some joints fitted together."""
        weights = np.zeros(N_JOINTS)
        weights[list(joints)] = self._weights[list(joints)]
        regressor = self._problem.regressor
        active = active & regressor.acts[weights > 0.0].any(0)
        return solve(normal, weights, regressor.prior, active)

    def squared_errors(self, active: Bools, joints: Iterable[int]) -> Array:
        """Return the squared residuals (folds, 7) of each fold, with some joints fitted."""
        return np.stack([fold.squared_error(self.fit(other, active, joints))
                         for fold, other in zip(self._problem.folds, self._others)])


def select(problem: Problem, weights: Array, wanted: Collection[str],
           unknown: Bools) -> list[Selection]:
    """
    Select the terms that improve the cross-validated residual, in the order of the problem.

    Terms named in ``wanted`` are always fitted, ``unknown`` parameters, (p,) bool, never. The
    first step has no term.
    """
    left_out = CrossValidation(problem, weights)
    active = problem.none()
    errors = np.stack([fold.square for fold in problem.folds])
    steps = [Selection('', (), problem.rms(errors), active.copy())]
    coupled = False  # whether a term that all joints share is fitted
    for term, where in _best_alternatives(problem, left_out, active):
        kept: list[int] = []
        shown = np.flatnonzero(~unknown[where]) + where.start
        parts = (_separate_parts(problem, term, where, shown, left_out, active, coupled)
                 if term.separate else _parts(term, shown, where))
        for joints, own in parts:
            trial = active.copy()
            trial[own] = True
            together = range(N_JOINTS) if coupled or term.shared else joints
            new = left_out.squared_errors(trial, together)[:, joints]
            if term.name in wanted or _is_better(new, errors[:, joints], term):
                active[own] = True
                errors[:, joints] = new
                kept += [joint for joint in joints if joint not in kept]
        coupled |= term.shared and bool(kept)
        steps.append(Selection(term.name, tuple(sorted(kept)), problem.rms(errors),
                               active.copy()))
    return steps


def _is_better(new: Array, old: Array, term: Term) -> bool:
    """Return whether new squared errors (folds, joints) are small enough for a term."""
    ratio = np.maximum(new.sum(0), 1e-12) / np.maximum(old.sum(0), 1e-12)
    in_most = not term.separate or np.mean(new < old) >= _MOST
    return bool(np.log(ratio).mean() < 2 * np.log1p(-term.worth) and in_most)


def _parts(term: Term, shown: Indices, where: slice) -> Iterator[tuple[list[int], Indices]]:
    """Yield the joints and parameters that are selected together."""
    if term.shared:
        yield list(range(N_JOINTS)), shown
        return
    for joint in range(N_JOINTS):
        own = np.intersect1d(_own(term, where, joint), shown)
        if len(own):
            yield [joint], own


def _separate_parts(problem: Problem, term: Term, where: slice, shown: Indices,
                    left_out: CrossValidation, active: Bools,
                    coupled: bool) -> Iterator[tuple[list[int], Indices]]:
    """Yield parameters that are large enough and help their joint, the most useful first."""
    for joint in range(N_JOINTS):
        together = range(N_JOINTS) if coupled else [joint]
        before = left_out.squared_errors(active, together)[:, [joint]]
        useful = []
        for k in np.intersect1d(_own(term, where, joint), shown).tolist():
            trial = active.copy()
            trial[k] = True
            errors = left_out.squared_errors(trial, together)[:, [joint]]
            b = left_out.fit(problem.whole, trial, together)
            value = term.read(problem.before)[k - where.start] + b[k]
            if abs(value) >= term.least and _is_better(errors, before, term):
                useful.append((errors.sum(), k))
        yield from (([joint], np.array([k])) for _, k in sorted(useful))


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
            scores.append(sum(np.log(left_out.squared_errors(trial, [joint])[:, joint].sum())
                              for joint in range(N_JOINTS)))
        yield alternatives[int(np.argmin(scores)) if scores else 0]

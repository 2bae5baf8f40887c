"""Selection of terms: what the motion shows, and what improves the cross-validated residual."""

from collections.abc import Collection, Iterable, Iterator
from itertools import groupby

import numpy as np

from .calibration_results import Selection
from .fit_data import turning
from .joint_terms import Term
from .least_squares import information, Problem
from ..model.arrays import Array, Bools, Indices
from ..model.joints import N_JOINTS

_UNKNOWN = 0.7  # ratio of posterior to prior deviation above which a parameter is unidentifiable
_MOST = 0.7  # share of the folds in which a parameter selected by itself must help


def unidentifiable(problem: Problem, weights: Array) -> tuple[Bools, dict[int, list[str]]]:
    """
    Find the parameters of single joints that the data do not show, even fitted with bias alone.

    This includes all of joints that do not reverse. Return a mask of the parameters, (p,), and the
    names of their terms by joint.
    """
    reverses = turning(problem.motions)
    known = information(problem.whole, weights, np.flatnonzero(~problem.none), problem.prior)
    bias = [where.start for term, where in problem.terms if term.name == 'bias']
    mask = problem.none.copy()
    lost: dict[int, list[str]] = {}
    for term, where in problem.terms:
        if term.shared or term.name == 'bias':
            continue
        for joint, k in np.argwhere(term.acts).tolist():
            k += where.start
            own = [k, *(start + joint for start in bias)]
            variance = np.linalg.inv(known[np.ix_(own, own)])[0, 0]
            if not reverses[joint] or np.sqrt(variance) > _UNKNOWN * problem.prior[k]:
                mask[k] = True
                if not term.separate and term.name not in lost.setdefault(joint, []):
                    lost[joint].append(term.name)
    return mask, lost


class Selector:
    """
    Forward selection of the terms that improve the cross-validated residual.

    Terms named in ``wanted`` are always fitted, ``unknown`` parameters, (p,) bool, never. The
    weights (7,) are 1 / variance of each joint's residual [1/(N m)^2].
    """

    def __init__(self, problem: Problem, weights: Array, wanted: Collection[str],
                 unknown: Bools) -> None:
        self._problem, self._weights = problem, weights
        self._wanted, self._unknown = wanted, unknown
        self._active = problem.none.copy()  # parameters selected so far
        self._errors = np.stack([fold[:, -1, -1] for fold in problem.folds])  # (folds, 7)
        self._coupled = False  # whether a term that all joints share is fitted

    def steps(self) -> list[Selection]:
        """Try the terms in the order of the problem; the first step has no term."""
        steps = [self._step('', ())]
        for term, where in self._best_alternatives():
            kept: set[int] = set()
            for joints, own in self._parts(term, where):
                weights = self._weights_of(range(N_JOINTS) if term.shared else joints)
                new = self._problem.cross_validate(weights, self._with(own))[:, joints]
                if term.name in self._wanted or _is_better(new, self._errors[:, joints], term):
                    self._active[own] = True
                    self._errors[:, joints] = new
                    kept.update(joints)
            self._coupled |= term.shared and bool(kept)
            steps.append(self._step(term.name, kept))
        return steps

    def _step(self, term: str, joints: Iterable[int]) -> Selection:
        return Selection(term, tuple(sorted(joints)), self._problem.rms(self._errors),
                         self._active.copy())

    def _with(self, parameters: 'Indices | slice | int') -> Bools:
        """Return the active parameters (p,) with some more."""
        active = self._active.copy()
        active[parameters] = True
        return active

    def _weights_of(self, joints: Iterable[int]) -> Array:
        """Return the weights (7,), zero for joints that need not be fitted with these."""
        own = np.isin(np.arange(N_JOINTS), list(joints))
        return np.where(own | self._coupled, self._weights, 0.0)

    def _best_alternatives(self) -> Iterator[tuple[Term, slice]]:
        """Yield the terms and their slices; of the Dahl terms only that with the best length."""
        for _, group in groupby(self._problem.terms, lambda pair: pair[0].name):
            alternatives = list(group)
            scores = []
            for _, where in alternatives if len(alternatives) > 1 else []:
                each = [self._problem.cross_validate(weights, self._with(where))[:, joint].sum()
                        for joint, weights in enumerate(np.diag(self._weights))]
                scores.append(np.log(each).sum())
            yield alternatives[int(np.argmin(scores)) if scores else 0]

    def _parts(self, term: Term, where: slice) -> Iterator[tuple[list[int], Indices]]:
        """Yield the joints and parameters that are selected together."""
        known = ~self._unknown[where]
        if term.shared:
            yield list(range(N_JOINTS)), where.start + np.flatnonzero(known)
            return
        for joint in range(N_JOINTS):
            own = where.start + np.flatnonzero(term.acts[joint] & known)
            if term.separate:
                yield from (([joint], part) for part in self._useful(term, where, joint, own))
            elif len(own):
                yield [joint], own

    def _useful(self, term: Term, where: slice, joint: int, own: Indices) -> Iterator[Indices]:
        """Yield parameters that are large enough and help their joint, the most useful first."""
        problem, weights = self._problem, self._weights_of([joint])
        before = problem.cross_validate(weights, self._active)[:, [joint]]
        useful = []
        for k in own.tolist():
            trial = self._with(k)
            errors = problem.cross_validate(weights, trial)[:, [joint]]
            change = problem.fit(problem.whole, weights, trial)[k]
            value = term.read(problem.before)[k - where.start] + change
            if abs(value) >= term.least and _is_better(errors, before, term):
                useful.append((errors.sum(), k))
        yield from (np.array([k]) for _, k in sorted(useful))


def _is_better(new: Array, old: Array, term: Term) -> bool:
    """Return whether new squared errors (folds, joints) are small enough for a term."""
    ratio = np.maximum(new.sum(0), 1e-12) / np.maximum(old.sum(0), 1e-12)
    in_most = not term.separate or np.mean(new < old) >= _MOST
    return bool(np.log(ratio).mean() < 2 * np.log1p(-term.worth) and in_most)

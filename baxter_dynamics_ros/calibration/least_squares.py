"""Regularised least squares, and the selection of terms by cross-validation."""

from collections.abc import Collection, Iterator
from itertools import groupby
from typing import Any

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

from .calibration_results import Selection
from .fit_data import CalibrationError, Motion, turning
from .joint_terms import Sample, Term
from ..estimation.settings import PredictorSettings
from ..model import ArgumentError, Array, Bools, Indices, JOINTS, N_JOINTS
from ..recordings.data_check import Notice

SHORTEST = 1.0  # minimum correlation time, because model errors recur with the motion [s]

_ROWS = 1024  # rows per block; the regressor of the links has 784 numbers per row
_UNKNOWN = 0.7  # ratio of posterior to prior deviation above which a parameter is unidentifiable
_MOST = 0.7  # share of the folds in which a parameter selected by itself must help


class Problem:
    """
    Least-squares problem of p deviations from some settings, with sums over each motion, a fold.

    The sums are [X_j y_j]^T W_j [X_j y_j] for each joint j, (7, p + 1, p + 1). X_j is the
    regressor, y_j the residual before the fit, both without the crosstalk of the model, and W_j
    the weights of the samples, (n, 7) for each motion and by default 1. The problem is linearised
    about some deviations (p,), by default 0.
    """

    def __init__(self, before: PredictorSettings, terms: list[Term], motions: list[Motion],
                 sample_weights: list[Array] | None = None, about: Array | None = None) -> None:
        ends = np.cumsum([len(term.prior) for term in terms]).tolist()
        self.before = before
        self.motions = motions
        self.terms: list[tuple[Any, slice]] = [  # with the slices of their parameters
            (term, slice(end - len(term.prior), end)) for end, term in zip(ends, terms)]
        self.prior = np.concatenate([term.prior for term in terms])  # (p,) standard deviations
        self.lower = np.concatenate([term.lower for term in terms])  # (p,) lower bounds
        self.tied = np.concatenate([term.tied for term in terms])  # (p,) bool
        self.acts = np.concatenate([term.acts for term in terms], axis=1)  # (7, p) bool
        self._sample_weights = sample_weights or [np.ones(motion.q.shape) for motion in motions]
        self._about = np.zeros(ends[-1]) if about is None else about
        self._model = self.updated(self._about).model
        self.folds = [*map(self._sums, motions, self._sample_weights)]
        self.whole: Array = sum(self.folds[1:], self.folds[0])
        self.others = [self.whole - fold for fold in self.folds]

    def about(self, deviation: Array) -> 'Problem':
        """Return the problem linearised about the settings with the deviations (p,)."""
        return Problem(self.before, [term for term, _ in self.terms], self.motions,
                       self._sample_weights, deviation)

    def mask(self, *names: str) -> Bools:
        """Return whether each parameter (p,) belongs to one of some terms."""
        return np.concatenate([np.full(len(term.prior), term.name in names)
                               for term, _ in self.terms])

    def _sums(self, motion: Motion, weight: Array) -> Array:
        p = len(self.prior)
        sums = np.zeros((N_JOINTS, p + 1, p + 1))
        lengths = {self._model.effort_model.dahl_length, *(
            term.constants['dahl_length'] for term, _ in self.terms if term.name == 'dahl')}
        for start in range(0, len(motion), _ROWS):
            rows = slice(start, start + _ROWS)
            blocks = self._rows(motion.take(rows), {
                length: motion.presliding(length)[rows] for length in lengths})
            for joint, xy in enumerate(blocks):
                index = np.append(np.flatnonzero(self.acts[joint]), p)
                weighted = xy * weight[rows, joint, None]
                sums[joint][np.ix_(index, index)] += weighted.T @ xy
        return sums

    def _rows(self, motion: Motion, presliding: dict[float, Array]) -> list[Array]:
        """Return [X_j y_j] of each joint, with the columns that act on it."""
        arm, model = self._model.arm, self._model.effort_model
        # torque() inverts the crosstalk: the parameters of a joint act on that joint alone.
        inertial = (arm.inverse_dynamics(motion.q, motion.qd, motion.qdd)
                    + model.added_inertia * motion.qdd)
        measured, present = (model.torque(effort, motion.q, motion.qd, presliding[
            model.dahl_length]) for effort in (motion.effort, np.zeros(motion.q.shape)))
        sample = Sample(motion, presliding, arm, inertial - present)
        result = []
        for joint, y in enumerate((measured - inertial).T):
            x = np.concatenate([np.empty((len(y), 0)), *(
                term.columns(sample, joint) for term, _ in self.terms
                if term.acts[joint].any())], axis=1)
            y = y + x @ self._about[self.acts[joint]]
            result.append(np.column_stack([x, y]))
        return result

    def updated(self, b: Array) -> PredictorSettings:
        """Return the settings with the deviations b (p,); CalibrationError if out of range."""
        values: dict[str, Any] = {}
        for term, where in self.terms:
            if b[where].any():
                values.update(term.values(self.before, b[where]))
        try:
            return self.before.replace(values)
        except ArgumentError as error:
            raise CalibrationError(f'the fit leaves the range of a parameter: {error}') from None

    def weights(self, rms: Array, correlation_time: Array | float = SHORTEST) -> Array:
        """Return 1 / variance (7,) for one sample per correlation time [1/(N m)^2]."""
        rate = sum(map(len, self.motions)) / sum(motion.duration for motion in self.motions)
        return 1 / (np.maximum(rms, 1e-4) ** 2 * np.maximum(rate * correlation_time, 1.0))

    def rms(self, squared_errors: Array) -> Array:
        """Return the RMS (7,) of the squared residuals (folds, 7) of all folds [N m]."""
        count = np.concatenate(self._sample_weights).sum(0)
        return np.sqrt(squared_errors.sum(0) / count)

    def fit(self, sums: Array, weights: Array, active: Bools) -> Array:
        """Return the deviations (p,) of the active parameters that fit sums."""
        return solve(sums, weights, active, self.prior, self.lower)

    def cross_validate(self, weights: Array, active: Bools) -> Array:
        """Return the squared residuals (folds, 7) of each fold with the fit to the others."""
        return np.stack([squared_error(fold, self.fit(other, weights, active))
                         for fold, other in zip(self.folds, self.others)])


def squared_error(sums: Array, b: Array) -> Array:
    """Return the sum of squared residuals of each joint (7,) at the deviations b (p,)."""
    y_less_xb = np.append(-b, 1.0)
    index = np.flatnonzero(y_less_xb)
    y_less_xb = y_less_xb[index]
    return np.maximum(y_less_xb @ sums[:, index[:, None], index] @ y_less_xb, 0.0)


def solve(sums: Array, weights: Array, active: Bools, prior: Array, lower: Array,
          known: Array | None = None) -> Array:
    """
    Return the most probable deviations, (p,), given standard deviations and lower bounds.

    The weights (7,) are 1 / variance of each joint's residual [1/(N m)^2]. Parameters that are not
    active, (p,) bool, keep ``known``, or are zero.
    """
    b = np.zeros(len(active)) if known is None else np.where(active, 0.0, known)
    if not active.any():
        return b
    index = np.flatnonzero(active)
    index = index[np.argsort(np.isfinite(lower[index]), kind='stable')]  # bounded ones last
    vector = np.tensordot(weights, sums[:, index, :] @ np.append(-b, 1.0), 1)
    root = np.linalg.cholesky(information(sums, weights, index, prior)).T
    right = solve_triangular(root, vector, trans='T')
    b[index] = solve_triangular(root, right)
    if (b < lower)[index].any():
        n = np.isinf(lower[index]).sum()
        bounded = lower[index[n:]]
        above, _ = nnls(root[n:, n:], right[n:] - root[n:, n:] @ bounded, maxiter=1000)
        b[index[n:]] = bounded + above
        if n:  # SciPy 1.11 refuses an empty matrix
            b[index[:n]] = solve_triangular(root[:n, :n], right[:n] - root[:n, n:] @ b[index[n:]])
    return b


def information(sums: Array, weights: Array, index: Indices, prior: Array) -> Array:
    """Return the inverse of the covariance of some parameters, prior and data together."""
    data: Any = np.tensordot(weights, sums[:, index[:, None], index], 1)
    return data + np.diag(prior[index] ** -2.0)


def unidentifiable(problem: Problem, weights: Array) -> tuple[Bools, list[Notice]]:
    """
    Find parameters of single joints that the data do not determine, even fitted with bias alone.

    This includes all of joints that do not reverse. Return a mask of the parameters, (p,), and a
    notice for each joint.
    """
    reverses = turning(problem.motions)
    known = information(problem.whole, weights, np.arange(len(problem.prior)), problem.prior)
    biases = np.flatnonzero(problem.mask('bias'))  # of each joint, or none
    mask = problem.mask()
    lost: dict[str, dict[str, None]] = {}  # the terms of each joint, once
    for term, where in problem.terms:
        if term.shared or term.name == 'bias':
            continue
        for joint, k in np.argwhere(term.acts).tolist():
            own = [where.start + k, *biases[joint:joint + 1]]
            variance = np.linalg.inv(known[np.ix_(own, own)])[0, 0]
            if not reverses[joint] or np.sqrt(variance) > _UNKNOWN * term.prior[k]:
                mask[own[0]] = True
                if not term.separate:
                    lost.setdefault(JOINTS[joint], {})[term.name] = None
    return mask, [Notice('unidentifiable', f'{joint}: the motion does not determine '
                         f'{", ".join(names)}: left unchanged', (joint,))
                  for joint, names in lost.items()]


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
        self._active = problem.mask()  # parameters selected so far
        self._errors = np.stack([fold[:, -1, -1] for fold in problem.folds])  # (folds, 7)

    def steps(self) -> list[Selection]:
        """Try the terms in the order of the problem; the first step has no term."""
        steps = [Selection('', (), self._problem.rms(self._errors), self._active)]
        for term, where in self._best_alternatives():
            kept: set[int] = set()
            for joints, own in self._parts(term, where):
                active = self._with(own)
                errors = self._problem.cross_validate(self._weights, active)
                if term.name in self._wanted or self._is_better(errors, joints, term):
                    # Errors of all joints, because they share terms.
                    self._active, self._errors = active, errors
                    kept.update(joints)
            steps.append(Selection(term.name, tuple(sorted(kept)),
                                   self._problem.rms(self._errors), self._active))
        return steps

    def _with(self, own: 'Indices | slice | int') -> Bools:
        """Return the active parameters (p,) with some more."""
        active = self._active.copy()
        active[own] = True
        return active

    def _best_alternatives(self) -> Iterator[tuple[Term, slice]]:
        """Yield the terms and their slices; of the Dahl terms only that with the best length."""
        for _, group in groupby(self._problem.terms, lambda pair: pair[0].name):
            alternatives = list(group)
            yield (min(alternatives, key=self._misfit) if len(alternatives) > 1
                   else alternatives[0])

    def _misfit(self, alternative: tuple[Term, slice]) -> float:
        """Return the sum of the logarithms of the squared errors, each joint fitted by itself."""
        errors = [self._problem.cross_validate(weights, self._with(alternative[1]))[:, joint]
                  for joint, weights in enumerate(np.diag(self._weights))]
        return float(np.log(np.sum(errors, axis=1)).sum())

    def _parts(self, term: Term, where: slice) -> Iterator[tuple[list[int], Indices]]:
        """Yield the joints and parameters that are selected together."""
        known = ~self._unknown[where]
        if term.shared:
            yield list(range(N_JOINTS)), where.start + np.flatnonzero(known)
            return
        for joint in range(N_JOINTS):
            own = where.start + np.flatnonzero(term.acts[joint] & known)
            parts = self._useful(term, where, joint, own) if term.separate else [own]
            yield from (([joint], part) for part in parts if len(part))

    def _useful(self, term: Term, where: slice, joint: int, own: Indices) -> list[Indices]:
        """Return parameters that are large enough and help their joint, the most useful first."""
        problem, useful = self._problem, []
        for k in own.tolist():
            active = self._with(k)
            errors = problem.cross_validate(self._weights, active)
            value = (term.read(problem.before)[k - where.start]
                     + problem.fit(problem.whole, self._weights, active)[k])
            if abs(value) >= term.least and self._is_better(errors, [joint], term):
                useful.append((errors[:, joint].sum(), k))
        return [np.array([k]) for _, k in sorted(useful)]

    def _is_better(self, errors: Array, joints: list[int], term: Term) -> bool:
        """Return whether squared residuals (folds, 7) are small enough at the joints of a term."""
        new, old = errors[:, joints], self._errors[:, joints]
        ratio = np.maximum(new.sum(0), 1e-12) / np.maximum(old.sum(0), 1e-12)
        in_most = not term.separate or np.mean(new < old) >= _MOST
        return bool(np.log(ratio).mean() < 2 * np.log1p(-term.worth) and in_most)

"""Regularised least squares: sums over the samples of a fit, and its solution."""

from typing import Any

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

from .fit_data import Motion
from .joint_terms import Sample, Term
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array, Bools, Indices
from ..model.joints import N_JOINTS

SHORTEST = 1.0  # minimum correlation time, because model errors recur with the motion [s]

_ROWS = 1024  # rows per block; the regressor of the links has 784 numbers per row


class Problem:
    """
    Least-squares problem of p deviations from some settings, with sums over each motion, a fold.

    The sums are [X_j y_j]^T W_j [X_j y_j] for each joint j, (7, p + 1, p + 1). X_j is the
    regressor, y_j the residual before the fit, both without the crosstalk of the model, and W_j
    the weights of the samples. The problem is linearised about some deviations (p,).
    """

    def __init__(self, before: PredictorSettings, terms: list[Term], motions: list[Motion],
                 about: Array | None = None) -> None:
        ends = np.cumsum([len(term.prior) for term in terms]).tolist()
        self.before = before
        self.motions = motions
        self.terms: list[tuple[Any, slice]] = [  # with the slices of their parameters
            (term, slice(end - len(term.prior), end)) for end, term in zip(ends, terms)]
        self.prior = np.concatenate([term.prior for term in terms])  # (p,) standard deviations
        self.lower = np.concatenate([term.lower for term in terms])  # (p,) lower bounds
        self.tied = np.concatenate([term.tied for term in terms])  # (p,) bool
        self.acts = np.concatenate([term.acts for term in terms], axis=1)  # (7, p) bool
        self.none = np.zeros(ends[-1], dtype=bool)  # mask of no parameter
        self._about = np.zeros(ends[-1]) if about is None else about
        self._model = self.updated(self._about).model
        self.folds = [self._sums(motion) for motion in motions]
        self.whole: Array = sum(self.folds[1:], self.folds[0])
        self.others = [self.whole - fold for fold in self.folds]

    def about(self, deviation: Array) -> 'Problem':
        """Return the problem linearised about the settings with the deviations (p,)."""
        return Problem(self.before, [term for term, _ in self.terms], self.motions, deviation)

    def _sums(self, motion: Motion) -> Array:
        p = len(self.prior)
        sums = np.zeros((N_JOINTS, p + 1, p + 1))
        lengths = {self._model.effort_model.dahl_length, *(
            term.constants['dahl_length'] for term, _ in self.terms if term.name == 'dahl')}
        presliding = motion.presliding(*lengths)
        for start in range(0, len(motion), _ROWS):
            rows = slice(start, start + _ROWS)
            part = motion.take(rows)
            blocks = self._rows(part, {length: z[rows] for length, z in presliding.items()})
            for joint, xy in enumerate(blocks):
                index = np.append(np.flatnonzero(self.acts[joint]), p)
                weighted = xy * part.weight[:, joint, None]
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
        """Return the settings with the deviations b (p,)."""
        values: dict[str, Any] = {}
        for term, where in self.terms:
            if b[where].any():
                values.update(term.values(self.before, b[where]))
        return self.before.replace(values) if values else self.before

    def weights(self, rms: Array, correlation_time: Array | float = SHORTEST) -> Array:
        """Return 1 / variance (7,) for one sample per correlation time [1/(N m)^2]."""
        rate = sum(map(len, self.motions)) / sum(motion.duration for motion in self.motions)
        return 1 / (np.maximum(rms, 1e-4) ** 2 * np.maximum(rate * correlation_time, 1.0))

    def rms(self, squared_errors: Array) -> Array:
        """Return the RMS (7,) of the squared residuals (folds, 7) of all folds [N m]."""
        count = sum(motion.weight.sum(0) for motion in self.motions)
        return np.sqrt(squared_errors.sum(0) / count)

    def fit(self, sums: Array, weights: Array, active: Bools) -> Array:
        """Return the deviations (p,) that fit sums at the joints whose weight is not zero."""
        return solve(sums, weights, active & self.acts[weights > 0.0].any(0), self.prior,
                     self.lower)

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
        b[index[:n]] = solve_triangular(root[:n, :n], right[:n] - root[:n, n:] @ b[index[n:]])
    return b


def information(sums: Array, weights: Array, index: Indices, prior: Array) -> Array:
    """Return the inverse of the covariance of some parameters, prior and data together."""
    data: Any = np.tensordot(weights, sums[:, index[:, None], index], 1)
    return data + np.diag(prior[index] ** -2.0)

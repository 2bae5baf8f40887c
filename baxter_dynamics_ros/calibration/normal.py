"""Normal equations: sums over recordings from which a fit is computed."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import lsq_linear

from .fit_data import Motion
from .joint_terms import DahlFriction
from .noise import SHORTEST
from .term import Sample, Term
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS

_ROWS = 1024  # rows per block; the regressor of the links has 784 numbers per row


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """
    Sums over samples per joint, for p parameters.

    X_j is the regressor of joint j, y_j its residual before the fit, both without the crosstalk of
    the model, and W_j the weights of the samples.
    """

    matrix: Array  # (7, p, p) X_j^T W_j X_j
    vector: Array  # (7, p) X_j^T W_j y_j
    square: Array  # (7,) y_j^T W_j y_j
    count: Array  # (7,) sum of W_j

    def __add__(self, other: 'NormalEquations') -> 'NormalEquations':
        """Return the sums over both."""
        return NormalEquations(self.matrix + other.matrix, self.vector + other.vector,
                               self.square + other.square, self.count + other.count)

    def __sub__(self, other: 'NormalEquations') -> 'NormalEquations':
        """Return the sums without those of the other."""
        return NormalEquations(self.matrix - other.matrix, self.vector - other.vector,
                               self.square - other.square, self.count - other.count)

    def squared_error(self, b: Array) -> Array:
        """Return the sum of squared residuals of each joint at the deviations b (p,), (7,)."""
        return np.maximum(self.square - 2 * self.vector @ b + b @ self.matrix @ b, 0.0)


class Prior(NamedTuple):
    """Prior of the deviations of p parameters."""

    deviation: Array  # (p,) standard deviations
    lower: Array  # (p,) lower bounds


class Regressor:
    """
    Regressor of all terms; their deviations form one vector.

    Parameters
    ----------
    settings : PredictorSettings
        Model about which tilt and links are linearised.
    terms : list of Term
        Terms, whose parameters are ``slices`` of the vector.
    deviation : ndarray (p,), optional
        Deviations that the settings already contain; zero by default.

    """

    def __init__(self, settings: PredictorSettings, terms: list[Term],
                 deviation: Array | None = None) -> None:
        self.settings = settings
        self.terms = terms
        ends = np.cumsum([len(term.prior) for term in terms])
        self.slices = [slice(end - len(term.prior), end) for end, term in zip(ends, terms)]
        self.prior = Prior(*(np.concatenate(arrays) for arrays in zip(
            *((term.prior, term.lower) for term in terms))))
        self.acts = np.concatenate([term.acts for term in terms], axis=1)
        self._deviation = np.zeros(self.acts.shape[1]) if deviation is None else deviation

    def normal_equations(self, motion: Motion) -> NormalEquations:
        """Return the sums over a motion."""
        p = len(self._deviation)
        matrix, vector = np.zeros((N_JOINTS, p, p)), np.zeros((N_JOINTS, p))
        square = np.zeros(N_JOINTS)
        for x, y, weight in self._rows(motion):
            for joint, acts in enumerate(self.acts):
                weighted = x[joint].T * weight[:, joint]
                matrix[joint][np.ix_(acts, acts)] += weighted @ x[joint]
                vector[joint, acts] += weighted @ y[:, joint]
            square += (weight * y * y).sum(0)
        return NormalEquations(matrix, vector, square, motion.weight.sum(0))

    def _rows(self, motion: Motion) -> Iterator[tuple[list[Array], Array, Array]]:
        """Yield the columns X_j that act on each joint, y and W (n, 7), some rows at a time."""
        arm, model = self.settings.model.arm, self.settings.model.effort_model
        lengths = sorted({model.dahl_length, *(term.length for term in self.terms
                                               if isinstance(term, DahlFriction))})
        states = motion.presliding(np.array(lengths)[:, None])
        for start in range(0, len(motion), _ROWS):
            rows = slice(start, start + _ROWS)
            part = motion.take(rows)
            presliding = dict(zip(lengths, states[rows].swapaxes(0, 1)))
            # torque() inverts the crosstalk: the parameters of a joint act on that joint alone.
            inertial = (arm.inverse_dynamics(part.q, part.qd, part.qdd)
                        + model.added_inertia * part.qdd)
            measured, present = (model.torque(effort, part.q, part.qd, presliding[
                model.dahl_length]) for effort in (part.effort, np.zeros(part.q.shape)))
            y = measured - inertial
            sample = Sample(part, presliding, arm, inertial - present)
            columns = [np.concatenate([term.columns(sample, joint) for term in self.terms
                                       if term.acts[joint].any()] or [y[:, :0]], axis=1)
                       for joint in range(N_JOINTS)]
            for joint, x in enumerate(columns):
                y[:, joint] += x @ self._deviation[self.acts[joint]]
            yield columns, y, part.weight


@dataclass(frozen=True, eq=False)
class Problem:
    """Terms and data of a fit, and their normal equations."""

    before: PredictorSettings
    regressor: Regressor
    motions: list[Motion]
    folds: list[NormalEquations]  # one per motion
    whole: NormalEquations  # sums over all motions

    @classmethod
    def of(cls, before: PredictorSettings, regressor: Regressor,
           motions: list[Motion]) -> 'Problem':
        """Return the problem with its normal equations."""
        folds = [regressor.normal_equations(motion) for motion in motions]
        return cls(before, regressor, motions, folds, sum(folds[1:], folds[0]))

    def about(self, deviation: Array) -> 'Problem':
        """Return the problem linearised about the settings with the deviations (p,)."""
        settings = self.updated(deviation)
        regressor = Regressor(settings, self.regressor.terms, deviation)
        return Problem.of(self.before, regressor, self.motions)

    def weights(self, rms: Array, correlation_time: Array | float = SHORTEST) -> Array:
        """Return 1 / variance (7,) for one sample per correlation time [1/(N m)^2]."""
        rate = sum(map(len, self.motions)) / sum(motion.duration for motion in self.motions)
        return 1 / (np.maximum(rms, 1e-4) ** 2 * np.maximum(rate * correlation_time, 1.0))

    def rms(self, squared_errors: Array) -> Array:
        """Return the RMS (7,) of the squared residuals (folds, 7) of all folds [N m]."""
        return np.sqrt(squared_errors.sum(0) / self.whole.count)

    def none(self) -> Bools:
        """Return the mask (p,) of no parameter."""
        return np.zeros(self.regressor.acts.shape[1], dtype=bool)

    @property
    def terms(self) -> list[tuple[Any, slice]]:
        """Return the terms and their parameters."""
        return list(zip(self.regressor.terms, self.regressor.slices))

    def updated(self, b: Array) -> PredictorSettings:
        """Return the settings with the deviations b (p,)."""
        settings = self.before
        for term, where in self.terms:
            if b[where].any():
                settings = term.updated(settings, b[where])
        return settings


def pose(settings: PredictorSettings, terms: list[Term], motions: list[Motion]) -> Problem:
    """Return the problem of fitting some terms to some motions."""
    return Problem.of(settings, Regressor(settings, terms), motions)


def solve(normal: NormalEquations, weights: Array, prior: Prior, active: Bools,
          known: Array | None = None) -> Array:
    """
    Return the most probable deviations, (p,): regularised least squares.

    The weights (7,) are 1 / variance of each joint's residual [1/(N m)^2]. Parameters that are not
    active, (p,) bool, keep ``known``, or are zero.
    """
    b = np.zeros(len(active)) if known is None else np.where(active, 0.0, known)
    if not active.any():
        return b
    vector = weights @ (normal.vector - normal.matrix @ b)[:, active]
    lower = prior.lower[active]
    factor = cho_factor(information(normal, weights, prior, active), lower=False)
    free = cho_solve(factor, vector)
    if (free < lower).any():
        upper = np.triu(factor[0])
        free = lsq_linear(upper, solve_triangular(upper, vector, trans='T'),
                          bounds=(lower, np.inf), method='bvls').x
    b[active] = free
    return b


def information(normal: NormalEquations, weights: Array, prior: Prior, active: Bools) -> Array:
    """Return the inverse of the covariance of the active parameters, prior and data together."""
    index = np.flatnonzero(active)
    data: Any = np.tensordot(weights, normal.matrix[:, index[:, None], index], 1)
    return data + np.diag(prior.deviation[index] ** -2.0)

"""Normal equations: sums over recordings from which a fit is computed."""

from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.optimize import lsq_linear

from .fit_data import Motion
from .term import Parameter, Sample, Term
from .terms import dahl_lengths
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array, Bools, Indices
from ..model.joints import N_JOINTS

_ROWS = 1024  # rows per block; the regressor of the links has 784 numbers per row


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """
    Sums over samples per joint, for p parameters.

    X_j is the regressor of joint j, and y_j its residual before the fit.
    """

    matrix: Array  # (7, p, p) X_j^T X_j
    vector: Array  # (7, p) X_j^T y_j
    square: Array  # (7,) y_j^T y_j
    count: int  # samples

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


class Regressor:
    """
    Regressor of all terms; their deviations form one vector.

    Parameters
    ----------
    settings : PredictorSettings
        Model before the fit, about which tilt and links are linearised.
    terms : list
        Terms from :func:`~.terms.all_terms`.

    Attributes
    ----------
    slices : list of slice
        Parameters of each term.
    parameters : tuple of Parameter
        Parameters of all terms.

    """

    def __init__(self, settings: PredictorSettings, terms: list[Term]) -> None:
        self.settings = settings
        self.terms = terms
        self._lengths = np.array(dahl_lengths(settings.effort_model))[:, None]
        ends = np.cumsum([len(term.parameters) for term in terms])
        self.slices = [slice(end - len(term.parameters), end) for end, term in zip(ends, terms)]
        self.parameters = sum((term.parameters for term in terms), ())
        self._acting = [
            np.concatenate([where.start + np.array(term.acting(joint), dtype=int)
                            for term, where in zip(terms, self.slices)])
            for joint in range(N_JOINTS)]
        self._deviation: Array = np.zeros(len(self.parameters))  # that the settings already hold

    def about(self, settings: PredictorSettings, deviation: Array) -> 'Regressor':
        """Return it linearised about the settings that the deviations (p,) lead to."""
        result = copy(self)
        result.settings = settings
        result._deviation = deviation
        return result

    def acting(self, joint: int) -> Indices:
        """Return the indices of the parameters that act on a joint."""
        return self._acting[joint]

    def normal_equations(self, motion: Motion) -> NormalEquations:
        """Return the sums over a motion."""
        p = len(self.parameters)
        matrix, vector = np.zeros((N_JOINTS, p, p)), np.zeros((N_JOINTS, p))
        square = np.zeros(N_JOINTS)
        for x, y in self._rows(motion):
            for joint, acting in enumerate(self._acting):
                matrix[joint][np.ix_(acting, acting)] += x[joint].T @ x[joint]
                vector[joint, acting] += x[joint].T @ y[:, joint]
            square += (y * y).sum(0)
        return NormalEquations(matrix, vector, square, len(motion))

    def _rows(self, motion: Motion) -> Iterator[tuple[list[Array], Array]]:
        """Yield the columns X_j that act on each joint, and y (n, 7), some rows at a time."""
        model = self.settings.effort_model
        presliding = motion.presliding(self._lengths)
        now = (motion.presliding(model.dahl_length) if model.has_dahl
               else np.zeros(motion.q.shape))
        for start in range(0, len(motion), _ROWS):
            rows = slice(start, start + _ROWS)
            part = motion.rows(rows.start, rows.stop)
            sample = Sample(part, presliding[rows], self.settings.arm)
            tau = self.settings.arm.inverse_dynamics(part.q, part.qd, part.qdd)
            y = part.effort - model.effort(tau, part.q, part.qd, part.qdd, now[rows])
            nothing = np.empty((len(part), 0))
            columns = [np.concatenate([nothing, *(term.columns(sample, joint)
                                                  for term in self.terms if term.acting(joint))],
                                      axis=1)
                       for joint in range(N_JOINTS)]
            for joint, x in enumerate(columns):
                y[:, joint] += x @ self._deviation[self._acting[joint]]
            yield columns, y


def solve(normal: NormalEquations, weights: Array, parameters: Sequence[Parameter], active: Bools,
          known: Array | None = None) -> Array:
    """
    Return the most probable deviations, (p,): regularised least squares.

    Parameters
    ----------
    normal : NormalEquations
        Sums over the data.
    weights : ndarray (7,)
        Weight of each joint: 1 / variance of its residual [1/(N m)^2].
    parameters : sequence of Parameter
        Priors and bounds.
    active : ndarray (p,) of bool
        Parameters to fit; the others keep ``known``, or are zero.
    known : ndarray (p,), optional
        Deviations of the parameters that are not fitted.

    """
    b = np.zeros(len(parameters)) if known is None else np.where(active, 0.0, known)
    if not active.any():
        return b
    matrix = information(normal, weights, parameters, active)
    vector = weights @ (normal.vector - normal.matrix @ b)[:, active]
    lower = np.array([p.lower for p in parameters])[active]
    factor = cho_factor(matrix, lower=False)
    free = cho_solve(factor, vector)
    if (free < lower).any():
        upper = np.triu(factor[0])
        free = lsq_linear(upper, solve_triangular(upper, vector, trans='T'),
                          bounds=(lower, np.inf), method='bvls').x
    b[active] = free
    return b


def information(normal: NormalEquations, weights: Array, parameters: Sequence[Parameter],
                active: Bools) -> Array:
    """Return the inverse of the covariance of the active parameters, prior and data together."""
    index = np.flatnonzero(active)
    prior = np.array([p.prior for p in parameters])[active]
    data: Any = np.tensordot(weights, normal.matrix[:, index[:, None], index], 1)
    return data + np.diag(prior ** -2.0)

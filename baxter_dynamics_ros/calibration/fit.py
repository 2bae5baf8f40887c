"""Fit of a calibration: selection of terms, least squares, cross-validation."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np

from .body_terms import Links, Tilt, Tool
from .calibration_results import Judged, Selection
from .fit_data import Motion
from .identifiability import turning, unknown
from .noise import correlation_times, SHORTEST
from .normal import information, NormalEquations, Regressor, solve
from .selection import select
from .term import Fitted, Term
from ..estimation.predictor import Estimate
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS

_T = TypeVar('_T')

_LINK_MARGIN = 0.05  # minimum eigenvalue of 1 + S of a link
# Factor on the standard deviation of a link's prior until the link is consistent; larger steps
# would end far from the margin.
_TIGHTER = 0.9
_TIES = 6  # number of iterations that tie a payload's second moments to mass and centre
_WORSE = 0.01  # mean relative difference for which an earlier step is preferred


class Problem(NamedTuple):
    """Terms and data of a fit, and their normal equations."""

    before: dict[str, Any]  # all settings
    regressor: Regressor
    motions: list[Motion]
    folds: list[NormalEquations]  # one per motion

    @property
    def whole(self) -> NormalEquations:
        """Return the sums over all motions."""
        return sum(self.folds[1:], self.folds[0])

    def about(self, settings: dict[str, Any], deviation: Array) -> 'Problem':
        """Return the problem linearised about the settings that the deviations (p,) lead to."""
        regressor = self.regressor.about(PredictorSettings(settings), deviation)
        return self._replace(regressor=regressor, folds=_sums(regressor, self.motions))

    def weights(self, rms: Array, correlation_time: Array | float = SHORTEST) -> Array:
        """Return 1 / variance (7,) for one sample per correlation time [1/(N m)^2]."""
        rate = self.whole.count / sum(motion.duration for motion in self.motions)
        return 1 / (np.maximum(rms, 1e-4) ** 2 * np.maximum(rate * correlation_time, 1.0))

    def of_kind(self, kind: type[_T]) -> list[tuple[_T, slice]]:
        """Return the terms of a kind and their parameters."""
        return [(term, where) for term, where in zip(self.regressor.terms, self.regressor.slices)
                if isinstance(term, kind)]

    def updated(self, b: Array) -> dict[str, Any]:
        """Return the settings with the deviations b (p,)."""
        values = dict(self.before)
        for term, where in zip(self.regressor.terms, self.regressor.slices):
            if b[where].any():
                term.update(values, b[where])
        return values


class Choice(NamedTuple):
    """Selected terms, and a preliminary fit."""

    steps: list[Selection]
    unidentifiable: dict[int, list[str]]  # joint -> names of unidentifiable terms
    values: dict[str, Any]  # settings of the preliminary fit


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of a fit."""

    values: dict[str, Any]  # all settings
    parameters: list[Fitted]
    judged: list[Judged]
    left_out: list[Array]  # deviations (p,) of the fit without each motion

    @property
    def log_error(self) -> float:
        """Return the mean logarithm of the cross-validated RMS of the joints."""
        total = sum(one.duration * one.after ** 2 for one in self.judged)
        return _log_error(np.sqrt(total / sum(one.duration for one in self.judged)))


def pose(values: dict[str, Any], terms: list[Term], motions: list[Motion]) -> Problem:
    """Return the problem of fitting some terms to some motions."""
    regressor = Regressor(PredictorSettings(values), terms)
    return Problem(values, regressor, motions, _sums(regressor, motions))


def choose(problem: Problem, wanted: Collection[str]) -> Choice:
    """Select the terms; those named in ``wanted`` are always fitted."""
    weights = problem.weights(_spread(problem))
    mask, lost = unknown(problem.regressor, problem.whole, weights, turning(problem.motions))
    steps = select(problem.regressor, problem.folds, weights, wanted, mask)
    active = steps[-1].active
    b = _solve(problem, problem.whole, problem.weights(steps[-1].rms), active)
    return Choice(steps, lost, problem.updated(b))


def best_fit(problem: Problem, steps: Sequence[Selection]) -> tuple[Fit, int]:
    """
    Return the fit of all chosen terms, or of an earlier step if that predicts better.

    Parameters
    ----------
    problem : Problem
        Terms and data.
    steps : sequence of Selection
        From :func:`choose`.

    Returns
    -------
    tuple (Fit, int)
        The fit, and the index of the last step that is part of it.

    """
    errors = np.array([_log_error(step.rms) for step in steps])
    last = len(steps) - 1
    fit = fit_terms(problem, steps[last])
    while last > 0:
        earlier = int(np.argmin(errors[:last]))
        if fit.log_error < errors[earlier] + _WORSE:
            break
        other = fit_terms(problem, steps[earlier])
        if other.log_error < fit.log_error - _WORSE:
            fit, last = other, earlier
        else:
            errors[earlier] = np.inf  # the quick fit of this step promised too much
    return fit, last


def fit_terms(problem: Problem, step: Selection) -> Fit:
    """Fit the parameters kept by a step, and cross-validate over the motions."""
    active = step.active
    b = _solve(problem, problem.whole, problem.weights(step.rms), active)
    if _is_bilinear(problem, active):
        problem = problem.about(problem.updated(b), b)
    residuals = [residual(motion, problem.updated(b)) for motion in problem.motions]
    left_over = rms(np.concatenate(residuals))
    weights = problem.weights(left_over)
    left_out = [_solve(problem, problem.whole - fold, weights, active) for fold in problem.folds]
    values = problem.updated(_solve(problem, problem.whole, weights, active))
    # Correlated residuals widen the standard deviations but do not change the fit.
    times = correlation_times(residuals, [motion.period for motion in problem.motions])
    covariance = _covariance(problem, problem.weights(left_over, times), active, left_out)
    parameters = [fitted for term, where in zip(problem.regressor.terms, problem.regressor.slices)
                  if active[where].any()
                  for fitted in term.fitted(problem.before, values, covariance[where, where],
                                            active[where])]
    judged = [Judged(motion.name, motion.duration, rms(residual(motion, problem.before)),
                     rms(residual(motion, problem.updated(b))))
              for motion, b in zip(problem.motions, left_out)]
    return Fit(values, parameters, judged, left_out)


def _sums(regressor: Regressor, motions: list[Motion]) -> list[NormalEquations]:
    return [regressor.normal_equations(motion) for motion in motions]


def _log_error(rms: Array) -> float:
    return float(np.log(np.maximum(rms, 1e-4)).mean())


def _spread(problem: Problem) -> Array:
    """Return the RMS (7,) of the residual after fitting bias and payload alone [N m]."""
    regressor = problem.regressor
    active = np.zeros(len(regressor.parameters), dtype=bool)
    for term, where in zip(regressor.terms, regressor.slices):
        active[where] = term.name in ('bias', 'payload')
    b = solve(problem.whole, np.ones(N_JOINTS), regressor.parameters, active)
    return np.sqrt(problem.whole.squared_error(b) / problem.whole.count)


def _is_bilinear(problem: Problem, active: Bools) -> bool:
    """Return whether both the tilt and links or payload are fitted: their product is bilinear."""
    terms = zip(problem.regressor.terms, problem.regressor.slices)
    kinds: set[type] = {type(term) for term, where in terms if active[where].any()}
    return Tilt in kinds and bool(kinds & {Links, Tool})


def _free(problem: Problem, active: Bools) -> Bools:
    """Return the active parameters that do not follow from others, (p,) bool."""
    free = active.copy()
    for term, where in problem.of_kind(Tool):
        free[where.start + np.array(term.fixed)] = False
    return free


def _solve(problem: Problem, normal: NormalEquations, weights: Array, active: Bools) -> Array:
    """Return the deviations (p,), with tied parameters and physically consistent links."""
    parameters = list(problem.regressor.parameters)
    free = _free(problem, active)
    b: Array = np.zeros(len(parameters))
    tools = [(term, where) for term, where in problem.of_kind(Tool) if active[where].any()]
    for _ in range(_TIES if tools else 1):
        b = solve(normal, weights, parameters, free, b)
        for term, where in tools:
            b[where.start + np.array(term.fixed)] = term.second_moments(b[where])
    for links, where in problem.of_kind(Links):
        while (least := links.least_eigenvalues(b[where])).min() < _LINK_MARGIN:
            link = 10 * int(np.argmin(least))  # tighten its prior
            for k in range(where.start + link, where.start + link + 10):
                parameters[k] = parameters[k].tightened(_TIGHTER)
            b = solve(normal, weights, parameters, free, b)
    return b


def _covariance(problem: Problem, weights: Array, active: Bools, left_out: list[Array]) -> Array:
    """
    Return the covariance of all parameters, (p, p).

    The covariance from noise and prior is scaled up to the jackknife variance of the fits without
    each motion, because an incomplete model fits every motion differently.
    """
    mask = _free(problem, active)
    free = np.flatnonzero(mask)
    covariance = np.zeros(2 * (len(mask),))
    covariance[np.ix_(free, free)] = np.linalg.inv(information(
        problem.whole, weights, problem.regressor.parameters, mask))
    jackknife = (len(left_out) - 1) * np.var(left_out, axis=0)
    scale = np.ones(len(covariance))
    scale[free] = np.sqrt(np.maximum(jackknife[free] / np.diag(covariance)[free], 1.0))
    return covariance * scale[:, None] * scale


def residual(motion: Motion, values: dict[str, Any]) -> Array:
    """Return the residual of a motion (n, 7) [N m], computed by the predictor."""
    settings = PredictorSettings(values)
    model = settings.effort_model
    presliding = (motion.presliding(model.dahl_length) if model.has_dahl
                  else np.zeros(motion.q.shape))
    result = settings.predictor().predict(Estimate(
        np.round(motion.time * 1e9).astype(int), motion.q, motion.qd, motion.qdd, motion.effort,
        presliding)).residual
    assert result is not None  # for the effort was measured
    return result


def rms(values: Array) -> Array:
    """Return the root of the mean square over the first axis."""
    return np.sqrt(np.mean(values ** 2, axis=0))

"""Fit of a calibration: selection of terms, least squares, cross-validation."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .body_terms import Links, Tilt, Tool
from .calibration_results import Judged, Selection
from .fit_data import residual, rms
from .joint_terms import Crosstalk, with_terms
from .noise import correlation_times, expected_deviation
from .normal import information, NormalEquations, Prior, Problem, solve
from .selection import select, unidentifiable
from .term import Fitted
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS

_LINK_MARGIN = 0.05  # minimum eigenvalue of 1 + S of a link
# Factor on the standard deviation of a link's prior until the link is consistent; larger steps
# would end far from the margin.
_TIGHTER = 0.9
_TIES = 6  # number of iterations that tie a payload's second moments to mass and centre
_WORSE = 0.01  # mean relative difference for which an earlier step is preferred


class Choice(NamedTuple):
    """Selected terms, and a preliminary fit."""

    steps: list[Selection]
    unidentifiable: dict[int, list[str]]  # joint -> names of unidentifiable terms
    settings: PredictorSettings  # of the preliminary fit


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of a fit."""

    settings: PredictorSettings
    parameters: list[Fitted]
    judged: list[Judged]
    left_out: list[Array]  # deviations (p,) of the fit without each motion

    @property
    def log_error(self) -> float:
        """Return the mean logarithm of the cross-validated RMS of the joints."""
        total = sum(one.duration * one.after ** 2 for one in self.judged)
        return _log_error(np.sqrt(total / sum(one.duration for one in self.judged)))


def choose(problem: Problem, wanted: Collection[str]) -> Choice:
    """Select the terms; those named in ``wanted`` are always fitted."""
    weights = problem.weights(_spread(problem))
    unknown, lost = unidentifiable(problem, weights)
    steps = select(problem, weights, wanted, unknown)
    b = _solve(problem, problem.whole, problem.weights(steps[-1].rms), steps[-1].active)
    return Choice(steps, lost, problem.updated(b))


def best_fit(problem: Problem, steps: Sequence[Selection]) -> tuple[Fit, int]:
    """
    Return the fit of all selected terms, or of an earlier step if that predicts better.

    The number is the index of the last step that is part of the fit.
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
        problem = problem.about(b)
    residuals = [residual(motion, problem.updated(b)) for motion in problem.motions]
    left_over = rms(np.concatenate(residuals))
    weights = problem.weights(left_over)
    left_out = [_solve(problem, problem.whole - fold, weights, active) for fold in problem.folds]
    settings = problem.updated(_solve(problem, problem.whole, weights, active))
    # Correlated residuals widen the standard deviations but do not change the fit.
    times = correlation_times(residuals, [motion.period for motion in problem.motions])
    covariance = _covariance(problem, problem.weights(left_over, times), active, left_out)
    parameters = [fitted for term, where in problem.terms if active[where].any()
                  for fitted in term.fitted(problem.before, settings, covariance[where, where],
                                            active[where])]
    left = [residual(motion, problem.updated(b)) for motion, b in zip(problem.motions, left_out)]
    judged = [Judged(motion.name, motion.duration, rms(residual(motion, problem.before)), rms(one))
              for motion, one in zip(problem.motions, left)]
    rest, velocity, acceleration = expected_deviation(
        np.concatenate(left), *(np.concatenate([getattr(motion, name) for motion in
                                                problem.motions]) for name in ('qd', 'qdd')))
    settings = with_terms(settings, deviation=rest, deviation_velocity=velocity,
                          deviation_acceleration=acceleration)
    return Fit(settings, parameters, judged, left_out)


def _log_error(rms: Array) -> float:
    return float(np.log(np.maximum(rms, 1e-4)).mean())


def _spread(problem: Problem) -> Array:
    """Return the RMS (7,) of the residual after fitting bias and payload alone [N m]."""
    active = problem.none()
    for term, where in problem.terms:
        active[where] = term.name in ('bias', 'payload')
    b = solve(problem.whole, np.ones(N_JOINTS), problem.regressor.prior, active)
    return problem.rms(problem.whole.squared_error(b)[None])


def _is_bilinear(problem: Problem, active: Bools) -> bool:
    """Return whether products of parameters are fitted: tilt and bodies, crosstalk and effort."""
    kinds = {type(term) for term, where in problem.terms if active[where].any()}
    return Tilt in kinds and bool(kinds & {Links, Tool}) or Crosstalk in kinds


def _free(problem: Problem, active: Bools) -> Bools:
    """Return the active parameters that do not follow from others, (p,) bool."""
    free = active.copy()
    for term, where in problem.terms:
        if isinstance(term, Tool):
            free[where.start + np.array(term.fixed)] = False
    return free


def _solve(problem: Problem, normal: NormalEquations, weights: Array, active: Bools) -> Array:
    """Return the deviations (p,), with tied parameters and physically consistent links."""
    prior = Prior(problem.regressor.prior.deviation.copy(), problem.regressor.prior.lower)
    free = _free(problem, active)
    b: Array = np.zeros(len(active))
    tools = [(term, where) for term, where in problem.terms
             if isinstance(term, Tool) and active[where].any()]
    for _ in range(_TIES if tools else 1):
        b = solve(normal, weights, prior, free, b)
        for term, where in tools:
            b[where.start + np.array(term.fixed)] = term.second_moments(b[where])
    for term, where in problem.terms:
        while isinstance(term, Links) and (
                least := term.least_eigenvalues(b[where])).min() < _LINK_MARGIN:
            link = where.start + 10 * int(np.argmin(least))
            prior.deviation[link:link + 10] *= _TIGHTER
            b = solve(normal, weights, prior, free, b)
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
    covariance[np.ix_(free, free)] = np.linalg.inv(
        information(problem.whole, weights, problem.regressor.prior, mask))
    jackknife = (len(left_out) - 1) * np.var(left_out, axis=0)
    scale = np.ones(len(covariance))
    scale[free] = np.sqrt(np.maximum(jackknife[free] / np.diag(covariance)[free], 1.0))
    return covariance * scale[:, None] * scale

"""Fit of a calibration: choice of terms, least squares, cross-validation, noise."""

from collections.abc import Collection, Sequence

import numpy as np
from scipy.optimize import nnls

from .calibration_results import Fitted, Judged, pooled, Selection
from .fit_data import residual
from .joint_terms import Crosstalk
from .least_squares import (information, Problem, Selector, SHORTEST, solve, squared_error,
                            unidentifiable)
from .terms import Links, Tilt, Tool
from ..estimation.settings import PredictorSettings
from ..model import Array, BAND, Bools, N_JOINTS, rms
from ..recordings.data_check import Notice

_LINK_MARGIN = 0.05  # minimum eigenvalue of 1 + S of a link
# Factor on the standard deviation of a link's prior until the link is consistent; larger steps
# would end far from the margin.
_TIGHTER = 0.9
_TIES = 6  # number of iterations that tie a payload's second moments to mass and centre
_WORSE = 0.01  # mean relative difference for which an earlier step is preferred
_COVERED = 0.95  # share of residuals within BAND deviations


def choose(problem: Problem, wanted: Collection[str]
           ) -> tuple[list[Selection], list[Notice], PredictorSettings]:
    """
    Return the steps of the selection, the unidentifiable parameters, and preliminary settings.

    Terms named in ``wanted`` are always fitted.
    """
    b = problem.fit(problem.whole, np.ones(N_JOINTS), problem.mask('bias', 'payload'))
    weights = problem.weights(problem.rms(squared_error(problem.whole, b)[None]))
    unknown, notices = unidentifiable(problem, weights)
    steps = Selector(problem, weights, wanted, unknown).steps()
    b = _solve(problem, problem.whole, problem.weights(steps[-1].rms), steps[-1].active)
    return steps, notices, problem.updated(b)


def best_fit(problem: Problem, steps: Sequence[Selection]
             ) -> tuple['Fit', Sequence[Selection]]:
    """Return the fit of the last step, or of a better earlier one, and the steps after that."""
    fit, last = Fit(problem, steps[-1]), len(steps) - 1
    for error, n in sorted((_log_error(step.rms), n) for n, step in enumerate(steps[:-1])):
        if fit.log_error < error + _WORSE:
            break
        # The quick fit of a step may promise too much.
        if n < last and (other := Fit(problem, steps[n])).log_error < fit.log_error - _WORSE:
            fit, last = other, n
    return fit, steps[last + 1:]


class Fit:
    """Fit of the parameters that a step keeps, cross-validated over the motions."""

    def __init__(self, problem: Problem, step: Selection) -> None:
        b = _solve(problem, problem.whole, problem.weights(step.rms), step.active)
        if _is_bilinear(problem, step.active):
            problem = problem.about(b)
        motions = problem.motions
        self._problem, self._active = problem, step.active
        self._residuals = [residual(motion, problem.updated(b)) for motion in motions]
        self._rms = rms(np.concatenate(self._residuals))
        weights = problem.weights(self._rms)
        self._b = _solve(problem, problem.whole, weights, step.active)
        # Deviations (p,) of the fit without each motion, and residuals of that motion.
        self.left_out = [_solve(problem, other, weights, step.active) for other in problem.others]
        self._left = [residual(motion, problem.updated(b))
                      for motion, b in zip(motions, self.left_out)]
        self.judged = [
            Judged(motion.name, motion.duration, rms(residual(motion, problem.before)),
                   (after := rms(left)), after) for motion, left in zip(motions, self._left)]

    @property
    def log_error(self) -> float:
        """Return the mean logarithm of the cross-validated RMS of the joints."""
        return _log_error(pooled(self.judged).after)

    @property
    def settings(self) -> PredictorSettings:
        """Return the fitted settings, with the deviation to expect from the left-out residual."""
        motions = self._problem.motions
        qd, qdd = (np.concatenate(arrays) for arrays in zip(*(
            (motion.qd, motion.qdd) for motion in motions)))
        deviation = expected_deviation(np.concatenate(self._left), qd, qdd)
        return self._problem.updated(self._b).replace(dict(zip((
            'effort_model.deviation', 'effort_model.deviation_velocity',
            'effort_model.deviation_acceleration'), deviation)))

    @property
    def parameters(self) -> list[Fitted]:
        """Return the fitted quantities with standard deviations."""
        problem, after = self._problem, self._problem.updated(self._b)
        covariance = self._covariance()
        return [fitted for term, where in problem.terms if self._active[where].any()
                for fitted in term.fitted(problem.before, after, covariance[where, where],
                                          self._active[where])]

    def _covariance(self) -> Array:
        """
        Return the covariance of all parameters, (p, p).

        Correlated residuals widen the covariance from noise and prior. That is scaled up to the
        jackknife variance of the fits without each motion, because an incomplete model fits every
        motion differently.
        """
        problem = self._problem
        times = correlation_times(self._residuals, [motion.period for motion in problem.motions])
        free = np.flatnonzero(self._active & ~problem.tied)
        covariance = np.zeros(2 * (len(self._active),))
        covariance[np.ix_(free, free)] = np.linalg.inv(information(
            problem.whole, problem.weights(self._rms, times), free, problem.prior))
        jackknife = (len(self.left_out) - 1) * np.var(self.left_out, axis=0)
        scale = np.ones(len(covariance))
        scale[free] = np.sqrt(np.maximum(jackknife[free] / np.diag(covariance)[free], 1.0))
        return covariance * scale[:, None] * scale


def _log_error(rms: Array) -> float:
    return float(np.log(np.maximum(rms, 1e-4)).mean())


def _is_bilinear(problem: Problem, active: Bools) -> bool:
    """Return whether products of parameters are fitted: tilt and bodies, crosstalk and effort."""
    kinds = {type(term) for term, where in problem.terms if active[where].any()}
    return Tilt in kinds and bool(kinds & {Links, Tool}) or Crosstalk in kinds


def _solve(problem: Problem, sums: Array, weights: Array, active: Bools) -> Array:
    """Return the deviations (p,), with tied parameters and physically consistent links."""
    prior, free = problem.prior.copy(), active & ~problem.tied
    b: Array = np.zeros(len(active))
    tools = [(term, where) for term, where in problem.terms
             if isinstance(term, Tool) and active[where].any()]
    for _ in range(_TIES if tools else 1):
        b = solve(sums, weights, free, prior, problem.lower, b)
        for term, where in tools:
            b[where][term.tied] = term.second_moments(b[where])
    for term, where in problem.terms:
        while isinstance(term, Links) and (
                least := term.least_eigenvalues(b[where])).min() < _LINK_MARGIN:
            link = where.start + 10 * int(np.argmin(least))
            prior[link:link + 10] *= _TIGHTER
            b = solve(sums, weights, free, prior, problem.lower, b)
    return b


def correlation_times(residuals: list[Array], periods: list[float]) -> Array:
    """
    Return the correlation times (7,) [s] of residuals (n, 7) of recordings with some periods [s].

    The integral of their autocorrelation, summed to where it has become small (Sokal's window).
    """
    times = []
    for left, period in zip(residuals, periods):
        x = left - left.mean(0)
        spectrum = np.abs(np.fft.rfft(x, 2 * len(x), axis=0)) ** 2
        correlation = np.fft.irfft(spectrum, axis=0)[:len(x)]
        integral = 2 * np.cumsum(correlation / np.maximum(correlation[0], 1e-12), axis=0) - 1
        is_small = np.arange(len(x))[:, None] >= 5 * integral
        end = np.where(is_small.any(0), is_small.argmax(0), -1)
        times.append(period * integral[end, range(N_JOINTS)])
    return np.maximum(np.mean(times, axis=0), SHORTEST)


def expected_deviation(left: Array, qd: Array, qdd: Array) -> tuple[Array, ...]:
    """
    Return standard deviations (7,) of residuals at rest, per velocity and per acceleration.

    The squares of residuals [N m], velocity [rad/s] and acceleration [rad/s^2], (n, 7), are
    related by least squares; the scale is such that 95 % of the residuals are within 1.96.
    """
    parts = np.stack([np.ones(qd.shape), qd ** 2, qdd ** 2], axis=-1)
    result = np.zeros((N_JOINTS, 3))
    for joint in range(N_JOINTS):
        x, y = parts[:, joint], left[:, joint] ** 2
        variance = np.full(len(y), y.mean() + 1e-9)
        for _ in range(5):  # the deviation of a square is proportional to the variance
            square, _ = nnls(x / variance[:, None], y / variance)
            variance = x @ square + 1e-9
        scale = np.quantile(np.sqrt(y / variance), _COVERED) / BAND
        result[joint] = scale * np.sqrt(square)
    return tuple(result.T)

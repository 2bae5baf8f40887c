"""One calibration: choose the terms, fit them, and judge the fit on what it never saw."""

from collections.abc import Collection
from typing import Any, TypeVar

import numpy as np

from .body_terms import Links, Tilt, Tool
from .calibration_results import Fitted, Judged
from .fit_data import Motion
from .identifiability import turning, unknown
from .noise import correlation_times, SHORTEST
from .normal import information, NormalEquations, Regressor, solve
from .selection import select
from .term import Term
from ..estimation.predictor import Estimate
from ..estimation.settings import PredictorSettings
from ..model.arrays import Array, Bools
from ..model.joints import N_JOINTS

_T = TypeVar('_T')

_LINK_MARGIN = 0.05  # least eigenvalue of 1 + S that a link may have
_TIES = 6  # times that a tool's second moments are found from its mass and centre of mass


class Fit:
    """
    A fit of some terms to some motions.

    Parameters
    ----------
    values : dict
        All settings before.
    terms : list
        What may be fitted, in the order in which it is tried.
    wanted : collection of str
        Names of terms that are fitted whatever they buy.
    motions : list of Motion
        Each is left out in turn to judge what the others give.

    Attributes
    ----------
    steps : list of Step
        What each term bought.
    values : dict
        All settings after.
    lost : dict
        Joint name -> names of the terms that the motions do not show.

    """

    def __init__(self, values: dict[str, Any], terms: list[Term], wanted: Collection[str],
                 motions: list[Motion]) -> None:
        self._before = values
        self._motions = motions
        self._regressor = Regressor(PredictorSettings(values), terms)
        self._sum_up()
        weights = self._weights(self._spread(), SHORTEST)
        mask, self.lost = unknown(self._regressor, self._whole, weights, turning(motions))
        selection = select(self._regressor, self._folds, weights, wanted, mask)
        self.steps, self._active = selection.steps, selection.active
        self._free = self._active & ~self._tied()
        b = self._solve(self._whole, self._weights(self.steps[-1].rms, SHORTEST))
        if self._is_bilinear():
            self._regressor = self._regressor.about(PredictorSettings(self._updated(b)), b)
            self._sum_up()
        residuals = [residual(motion, self._updated(b)) for motion in motions]
        self._final = self._weights(
            rms(np.concatenate(residuals)),
            correlation_times(residuals, [motion.period for motion in motions]))
        self._left_out = [self._solve(self._whole - fold, self._final) for fold in self._folds]
        self.values = self._updated(self._solve(self._whole, self._final))

    def judged(self) -> list[Judged]:
        """Return how well each motion is predicted by what the others gave."""
        return [Judged(motion.name, motion.duration, rms(residual(motion, self._before)),
                       rms(residual(motion, self._updated(b))))
                for motion, b in zip(self._motions, self._left_out)]

    def fitted(self) -> list[Fitted]:
        """Return the parameters that were fitted."""
        covariance = self._covariance()
        return [Fitted(term.name, *row)
                for term, where in zip(self._regressor.terms, self._regressor.slices)
                if self._active[where].any()
                for row in term.rows(self._before, self.values, covariance[where, where],
                                     self._active[where])]

    def _sum_up(self) -> None:
        self._folds = [self._regressor.normal_equations(motion) for motion in self._motions]
        self._whole = sum(self._folds[1:], self._folds[0])

    def _spread(self) -> Array:
        """Return the RMS (7,) that is left once bias and payload are known [N m]."""
        active = np.zeros(len(self._regressor.parameters), dtype=bool)
        for term, where in zip(self._regressor.terms, self._regressor.slices):
            active[where] = term.name in ('bias', 'payload')
        b = solve(self._whole, np.ones(N_JOINTS), self._regressor.parameters, active)
        return np.sqrt(self._whole.squared_error(b) / self._whole.count)

    def _weights(self, rms: Array, correlation_time: Array | float) -> Array:
        """Return 1 / variance (7,), as if there were a sample a correlation time [1/(N m)^2]."""
        rate = self._whole.count / sum(motion.duration for motion in self._motions)
        return 1 / (np.maximum(rms, 1e-4) ** 2 * np.maximum(rate * correlation_time, 1.0))

    def _is_bilinear(self) -> bool:
        """Return whether gravity's direction multiplies bodies, and both are fitted."""
        terms = zip(self._regressor.terms, self._regressor.slices)
        kinds: set[type] = {type(term) for term, where in terms if self._active[where].any()}
        return Tilt in kinds and bool(kinds & {Links, Tool})

    def _tied(self) -> Bools:
        """Return which parameters follow from others, (p,) of bool."""
        mask = np.zeros(len(self._regressor.parameters), dtype=bool)
        for term, where in self._of_kind(Tool):
            mask[where.start + np.array(term.fixed)] = True
        return mask

    def _of_kind(self, kind: type[_T]) -> list[tuple[_T, slice]]:
        return [(term, where) for term, where in zip(self._regressor.terms, self._regressor.slices)
                if isinstance(term, kind)]

    def _solve(self, normal: NormalEquations, weights: Array) -> Array:
        """Return the deviations (p,), with what is tied, and bodies that can exist."""
        parameters = list(self._regressor.parameters)
        b: Array = np.zeros(len(parameters))
        tools = [(term, where) for term, where in self._of_kind(Tool) if self._active[where].any()]
        for _ in range(_TIES if tools else 1):
            b = solve(normal, weights, parameters, self._free, b)
            for term, where in tools:
                b[where.start + np.array(term.fixed)] = term.second_moments(b[where])
        for links, where in self._of_kind(Links):
            while (least := links.least_eigenvalues(b[where])).min() < _LINK_MARGIN:
                link = 10 * int(np.argmin(least))  # believe more in what it was before
                for k in range(where.start + link, where.start + link + 10):
                    parameters[k] = parameters[k].tightened(0.7)
                b = solve(normal, weights, parameters, self._free, b)
        return b

    def _updated(self, b: Array) -> dict[str, Any]:
        """Return the settings with the deviations b."""
        values = dict(self._before)
        for term, where in zip(self._regressor.terms, self._regressor.slices):
            if b[where].any():
                term.update(values, b[where])
        return values

    def _covariance(self) -> Array:
        """
        Return the covariance of all parameters, (p, p).

        What noise and prior say, scaled up to what the fits without each motion in turn differ by
        (the jackknife): a model that lacks something fits each motion differently.
        """
        free = np.flatnonzero(self._free)
        covariance = np.zeros(2 * (len(self._free),))
        covariance[np.ix_(free, free)] = np.linalg.inv(information(
            self._whole, self._final, self._regressor.parameters, self._free))
        jackknife = (len(self._left_out) - 1) * np.var(self._left_out, axis=0)
        scale = np.ones(len(covariance))
        scale[free] = np.sqrt(np.maximum(jackknife[free] / np.diag(covariance)[free], 1.0))
        return covariance * scale[:, None] * scale


def residual(motion: Motion, values: dict[str, Any]) -> Array:
    """Return what settings leave over of a motion, (n, 7) [N m], by the node's own code."""
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

"""Sums, regularised least squares, choice of a fit and correlation times."""

from types import SimpleNamespace

from baxter_dynamics_ros.calibration.calibration_results import Selection
from baxter_dynamics_ros.calibration.fit import best_fit, correlation_times
from baxter_dynamics_ros.calibration.fit_data import residual
from baxter_dynamics_ros.calibration.least_squares import (
    Problem, Selector, SHORTEST, solve, squared_error)
from baxter_dynamics_ros.calibration.terms import all_terms
from calibration.known_robot import columns, decoupled, make_motion
import numpy as np
import pytest


def test_sums_are_those_of_all_rows(settings, rng):
    """The first motion is longer than a block of rows."""
    motions = [make_motion(1100, rng), make_motion(200, rng)]
    weights = [rng.uniform(0.2, 1.0, motion.q.shape) for motion in motions]
    terms = all_terms(settings, shape=True)
    problem = Problem(settings, terms, motions, weights)
    x, y = map(np.concatenate, zip(*(
        (np.concatenate([columns(term, settings, motion) for term in terms], axis=-1),
         decoupled(residual(motion, settings), settings)) for motion in motions)))
    w = np.concatenate(weights)
    xy = np.concatenate([x, y[..., None]], axis=-1)
    np.testing.assert_allclose(
        problem.whole, np.einsum('njp,nj,njq->jpq', xy, w, xy, optimize=True), rtol=1e-9,
        atol=1e-9)
    b = 0.1 * problem.prior
    errors = (w * (y - x @ b) ** 2).sum(0)
    np.testing.assert_allclose(squared_error(problem.whole, b), errors, rtol=1e-9)
    np.testing.assert_allclose(problem.rms(errors[None]), np.sqrt(errors / w.sum(0)))
    np.testing.assert_allclose(problem.others[1], problem.folds[0], rtol=1e-9, atol=1e-6)


def test_error_about_a_deviation_is_that_of_its_settings(settings, motion):
    """Products of tilt, links and crosstalk are exact after linearisation about the deviation."""
    rng = np.random.default_rng(8)
    weight = rng.uniform(0.2, 1.0, motion.q.shape)
    problem = Problem(settings, all_terms(settings, shape=False), [motion], [weight])
    b = np.zeros(len(problem.prior))
    for term, where in problem.terms:
        if term.name in ('bias', 'coulomb', 'tilt', 'inertial', 'stiffness', 'crosstalk'):
            b[where] = np.abs(rng.normal(0.0, 0.3 * term.prior))
    after = problem.updated(b)
    true = (weight * decoupled(residual(motion, after), after) ** 2).sum(0)
    np.testing.assert_allclose(squared_error(problem.about(b).whole, b), true, rtol=1e-9)
    assert np.abs(squared_error(problem.whole, b) / true - 1.0).max() > 1e-5


def test_solve_is_optimal_within_its_bounds(rng):
    """The gradient is zero at free parameters and points outwards at bounds."""
    x, y, weights = rng.normal(size=(40, 7, 6)), rng.normal(size=(40, 7)), rng.uniform(0.1, 4.0, 7)
    xy = np.concatenate([x, y[..., None]], axis=-1)
    sums = np.einsum('njp,njq->jpq', xy, xy)
    prior, every = np.array([0.05, 0.1, 0.02, 1.0, 3.0, 0.1]), np.ones(6, dtype=bool)
    free = solve(sums, weights, every, prior, np.full(6, -np.inf))
    lower = free + np.array([0.03, -1.0, 0.02, 0.05, -1.0, -1.0])  # three of them bind
    found = solve(sums, weights, every, prior, lower)
    assert (found >= lower).all()
    at_bound = found == lower
    assert at_bound.any() and not at_bound.all()
    gradient = np.einsum('j,njp,nj->p', weights, x, x @ found - y) + found / prior ** 2
    np.testing.assert_allclose(gradient[~at_bound], 0.0, atol=1e-9)
    assert (gradient[at_bound] > 0.0).all()


def test_rms_of_a_step_is_that_of_all_joints_with_its_parameters(settings, rng):
    """Friction of one joint changes the payload, and with it the residuals of the others."""
    problem = Problem(settings, all_terms(settings, shape=False)[:5],
                      [make_motion(300, rng) for _ in range(3)])
    for step in Selector(problem, np.ones(7), {'payload', 'coulomb'}, problem.mask()).steps():
        rms = problem.rms(problem.cross_validate(np.ones(7), step.active))
        np.testing.assert_allclose(step.rms, rms, err_msg=step.term)


def test_steps_after_a_better_one_are_not_tried(monkeypatch):
    errors = {'first': 0.0, 'second': -0.5, 'last': 1.0}
    monkeypatch.setattr(f'{best_fit.__module__}.Fit', lambda problem, step: SimpleNamespace(
        log_error=errors[step.term]))
    steps = [Selection(term, (), np.full(7, rms), np.ones(0, bool))
             for term, rms in zip(errors, (0.1, 0.2, 0.3))]
    fit, later = best_fit(None, steps)
    assert (fit.log_error, later) == (0.0, steps[1:])


@pytest.mark.parametrize('memory', [0.0, 2.5])
def test_correlation_time_of_noise_with_memory(memory, rng):
    """Noise that decays by exp(-t / memory) has a correlation time of twice its memory."""
    period = 0.05
    keep = np.exp(-period / memory) if memory else 0.0
    noise = rng.normal(size=(40_000, 7))
    for previous, row in zip(noise, noise[1:]):
        row += keep * previous
    found = correlation_times([noise[:20_000], 2.0 + noise[20_000:]], [period] * 2)
    assert found.mean() == pytest.approx(max(2 * memory, SHORTEST), rel=0.15)

"""Normal equations, regularised least squares, cross-validation and correlation times."""

from dataclasses import replace

from baxter_dynamics_ros.estimation.settings import PredictorSettings
import numpy as np
import pytest

pytest.importorskip('scipy', reason='needs SciPy: pip install ".[offline]"')

from baxter_dynamics_ros.calibration.fit_data import residual  # noqa: E402, I100
from baxter_dynamics_ros.calibration.noise import correlation_times, SHORTEST  # noqa: E402
from baxter_dynamics_ros.calibration.normal import (  # noqa: E402
    NormalEquations, pose, Prior, Problem, Regressor, solve)
from baxter_dynamics_ros.calibration.selection import CrossValidation  # noqa: E402
from baxter_dynamics_ros.calibration.terms import all_terms  # noqa: E402


@pytest.fixture(scope='module')
def two_motions(make_motion):
    """Return two motions; the first is longer than a block of rows."""
    rng = np.random.default_rng(5)
    return make_motion(1100, rng), make_motion(200, rng)


def test_normal_equations_are_sums_over_rows(settings, two_motions, columns, decoupled, rng):
    two_motions = [replace(motion, weight=rng.uniform(0.2, 1.0, motion.q.shape))
                   for motion in two_motions]
    problem = pose(settings, all_terms(settings, shape=True), two_motions)
    x = np.concatenate([np.concatenate(
        [columns(term, settings, motion) for term, _ in problem.terms], axis=-1)
        for motion in two_motions])
    y = np.concatenate([decoupled(residual(motion, settings), settings)
                        for motion in two_motions])
    w = np.concatenate([motion.weight for motion in two_motions])
    both = problem.whole
    np.testing.assert_allclose(both.count, w.sum(0))
    np.testing.assert_allclose(both.matrix, np.einsum('njp,nj,njq->jpq', x, w, x, optimize=True),
                               rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(both.vector, np.einsum('njp,nj->jp', x, w * y), rtol=1e-9,
                               atol=1e-9)
    np.testing.assert_allclose(both.square, (w * y ** 2).sum(0))
    b = 0.1 * problem.regressor.prior.deviation
    np.testing.assert_allclose(both.squared_error(b), (w * (y - x @ b) ** 2).sum(0), rtol=1e-9)
    first, second = problem.folds
    difference = both - second
    for name in ('matrix', 'vector', 'square', 'count'):
        np.testing.assert_allclose(getattr(difference, name), getattr(first, name),
                                   rtol=1e-9, atol=1e-6)


def test_error_about_a_deviation_is_that_of_its_settings(settings, motion, decoupled):
    """Products of tilt, links and crosstalk are exact after linearisation about the deviation."""
    problem = pose(settings, all_terms(settings, shape=False), [motion])
    rng = np.random.default_rng(8)
    b = np.zeros(len(problem.none()))
    for term, where in problem.terms:
        if term.name in ('bias', 'coulomb', 'tilt', 'inertial', 'stiffness', 'crosstalk'):
            b[where] = np.abs(rng.normal(0.0, 0.3 * term.prior))
    after = problem.updated(b)
    true = (decoupled(residual(motion, after), after) ** 2).sum(0)
    np.testing.assert_allclose(problem.about(b).whole.squared_error(b), true, rtol=1e-9)
    assert np.abs(problem.whole.squared_error(b) / true - 1.0).max() > 1e-5


def test_cross_validation_fits_without_each_fold(make_motion, columns, decoupled, rng):
    settings = PredictorSettings()
    terms = [term for term in all_terms(settings, shape=False)
             if term.name in ('bias', 'stiffness', 'tilt')]
    motions = [make_motion(n, rng) for n in (60, 90, 40)]
    problem = Problem.of(settings, Regressor(settings, terms), motions)
    weights, prior = rng.uniform(0.1, 1.0, 7), problem.regressor.prior
    chosen = weights * np.isin(np.arange(7), (1, 3))
    active = np.arange(len(prior.deviation)) % 3 > 0
    x = [np.concatenate([columns(term, settings, m) for term in terms], -1) for m in motions]
    y = [decoupled(residual(m, settings), settings) for m in motions]
    expected = np.zeros(7)
    for k in range(3):
        others = [i for i in range(3) if i != k]
        rows, right = stacked(np.concatenate([x[i] for i in others]),
                              np.concatenate([y[i] for i in others]), chosen, prior, active)
        b, *_ = np.linalg.lstsq(rows, right, rcond=None)
        expected += ((y[k] - x[k][..., active] @ b) ** 2).sum(0)
    found = CrossValidation(problem, weights).squared_errors(active, (1, 3)).sum(0)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.fixture
def random_problem(rng):
    """Return normal equations of a random problem, its rows, weights and prior."""
    n, p = 40, 6
    x, y = rng.normal(size=(n, 7, p)), rng.normal(size=(n, 7))
    normal = NormalEquations(np.einsum('njp,njq->jpq', x, x), np.einsum('njp,nj->jp', x, y),
                             (y ** 2).sum(0), np.full(7, n))
    prior = Prior(np.array([0.05, 0.1, 0.02, 1.0, 3.0, 0.1]), np.full(p, -np.inf))
    return normal, x, y, rng.uniform(0.1, 4.0, 7), prior


def stacked(x, y, weights, prior, active):
    """Return the rows of a least-squares problem: weighted samples of all joints, and priors."""
    root = np.sqrt(weights)[:, None]
    rows = (x * root).reshape(-1, x.shape[-1])
    return (np.concatenate([rows, np.diag(1.0 / prior.deviation)])[:, active],
            np.concatenate([(y * root[:, 0]).ravel(), np.zeros(len(active))]))


@pytest.mark.parametrize('active', [[1] * 6, [1, 1, 0, 1, 0, 1], [0] * 6],
                         ids=['all', 'some', 'none'])
def test_solve_is_least_squares_with_priors_as_rows(random_problem, active):
    normal, x, y, weights, prior = random_problem
    active = np.array(active, dtype=bool)
    known = np.where(active, 9.0, [0.0, 0.0, 0.3, 0.0, -0.2, 0.0])
    rows, right = stacked(x, y - x @ np.where(active, 0.0, known), weights, prior, active)
    found = solve(normal, weights, prior, active, known)
    np.testing.assert_allclose(found[active], np.linalg.lstsq(rows, right, rcond=None)[0],
                               atol=1e-12)
    np.testing.assert_array_equal(found[~active], known[~active])


def test_solve_is_optimal_within_its_bounds(random_problem):
    """The gradient is zero at free parameters and points outwards at bounds."""
    normal, x, y, weights, prior = random_problem
    every = np.ones(6, dtype=bool)
    free = solve(normal, weights, prior, every)
    lower = free + np.array([0.03, -1.0, 0.02, 0.05, -1.0, -1.0])  # three of them bind
    found = solve(normal, weights, prior._replace(lower=lower), every)
    assert (found >= lower).all()
    at_bound = found == lower
    assert at_bound.any() and not at_bound.all()
    rows, right = stacked(x, y, weights, prior, every)
    gradient = rows.T @ (rows @ found - right)
    np.testing.assert_allclose(gradient[~at_bound], 0.0, atol=1e-9)
    assert (gradient[at_bound] > 0.0).all()


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

"""Sums are sums, solutions are least squares with priors and bounds, and noise is what it is."""

from baxter_dynamics_ros.estimation.settings import PredictorSettings
import numpy as np
import pytest

pytest.importorskip('scipy', reason='needs SciPy: pip install ".[offline]"')

from baxter_dynamics_ros.calibration.fit import residual  # noqa: E402, I100
from baxter_dynamics_ros.calibration.noise import correlation_times, SHORTEST  # noqa: E402
from baxter_dynamics_ros.calibration.normal import NormalEquations, Regressor, solve  # noqa: E402
from baxter_dynamics_ros.calibration.selection import LeftOut  # noqa: E402
from baxter_dynamics_ros.calibration.term import Parameter  # noqa: E402
from baxter_dynamics_ros.calibration.terms import all_terms  # noqa: E402


@pytest.fixture(scope='module')
def long_motions(make_motion):
    """Return two motions; the first is longer than what is summed at a time."""
    rng = np.random.default_rng(5)
    return make_motion(1500, rng), make_motion(400, rng)


def test_normal_equations_are_sums_and_add_up(settings, long_motions, columns):
    regressor = Regressor(settings, all_terms(settings, shape=False))
    sums = [regressor.normal_equations(motion) for motion in long_motions]
    x = np.concatenate([np.concatenate(
        [columns(term, settings, motion) for term in regressor.terms], axis=-1)
        for motion in long_motions])
    y = np.concatenate([residual(motion, settings.values) for motion in long_motions])
    both = sums[0] + sums[1]
    assert both.count == len(y) == 1900
    np.testing.assert_allclose(both.matrix, np.einsum('njp,njq->jpq', x, x, optimize=True),
                               rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(both.vector, np.einsum('njp,nj->jp', x, y), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(both.square, (y ** 2).sum(0))
    b = np.array([0.1 * parameter.prior for parameter in regressor.parameters])
    np.testing.assert_allclose(both.squared_error(b), ((y - x @ b) ** 2).sum(0), rtol=1e-9)
    np.testing.assert_allclose((both - sums[1]).matrix, sums[0].matrix, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose((both - sums[1]).vector, sums[0].vector, rtol=1e-9, atol=1e-6)
    assert (both - sums[1]).count == 1500


def test_each_parameter_acts_where_its_columns_are_not_zero(settings, motion):
    regressor = Regressor(settings, all_terms(settings, shape=True))
    normal = regressor.normal_equations(motion)
    for joint in range(7):
        active = np.zeros(len(regressor.parameters), dtype=bool)
        active[regressor.acting(joint)] = True
        assert (np.diag(normal.matrix[joint])[~active] == 0.0).all()
        assert (normal.vector[joint][~active] == 0.0).all()


def test_about_a_deviation_the_error_is_that_of_its_settings(settings, motion):
    """Tilt and links multiply each other; linearised anew, nothing is left of the product."""
    regressor = Regressor(settings, all_terms(settings, shape=False))
    rng = np.random.default_rng(8)
    b = np.zeros(len(regressor.parameters))
    values = dict(settings.values)
    for term, where in zip(regressor.terms, regressor.slices):
        if term.name in ('bias', 'coulomb', 'tilt', 'inertial', 'stiffness'):
            b[where] = [abs(rng.normal(0.0, 0.3 * p.prior)) for p in term.parameters]
            term.update(values, b[where])
    true = (residual(motion, values) ** 2).sum(0)
    there = regressor.about(PredictorSettings(values), b).normal_equations(motion)
    np.testing.assert_allclose(there.squared_error(b), true, rtol=1e-9)
    here = regressor.normal_equations(motion).squared_error(b)
    assert np.abs(here / true - 1.0).max() > 1e-5  # the product is no small thing


def test_left_out_means_that_the_fit_did_not_see_it(make_motion, columns, rng):
    settings = PredictorSettings()
    regressor = Regressor(settings, [term for term in all_terms(settings, shape=False)
                                     if term.name in ('bias', 'stiffness', 'tilt')])
    motions = [make_motion(n, rng) for n in (60, 90, 40)]
    left_out = LeftOut(regressor, [regressor.normal_equations(motion) for motion in motions])
    weights, parameters = rng.uniform(0.1, 1.0, 7), regressor.parameters
    chosen = weights * np.isin(np.arange(7), (1, 3))
    active = np.array([k % 3 > 0 for k in range(len(parameters))])
    x = [np.concatenate([columns(term, settings, m) for term in regressor.terms], -1)
         for m in motions]
    y = [residual(m, settings.values) for m in motions]
    wanted = np.zeros(7)
    for k in range(3):
        others = [i for i in range(3) if i != k]
        rows, right = stacked(np.concatenate([x[i] for i in others]),
                              np.concatenate([y[i] for i in others]), chosen, parameters, active)
        b, *_ = np.linalg.lstsq(rows, right, rcond=None)
        wanted += ((y[k] - x[k][..., active] @ b) ** 2).sum(0)
    found = left_out.squared_error(weights, active, (1, 3))
    np.testing.assert_allclose(found, wanted, rtol=1e-9)
    np.testing.assert_allclose(left_out.rms(found), np.sqrt(wanted / 190))


@pytest.fixture
def problem(rng):
    """Return normal equations of a random problem, its rows, weights and parameters."""
    n, p = 40, 6
    x, y = rng.normal(size=(n, 7, p)), rng.normal(size=(n, 7))
    normal = NormalEquations(np.einsum('njp,njq->jpq', x, x), np.einsum('njp,nj->jp', x, y),
                             (y ** 2).sum(0), n)
    weights = rng.uniform(0.1, 4.0, 7)
    parameters = [Parameter(prior) for prior in (0.05, 0.1, 0.02, 1.0, 3.0, 0.1)]
    return normal, x, y, weights, parameters


def stacked(x, y, weights, parameters, active):
    """Return the rows of a least-squares problem: all joints' weighted samples, and priors."""
    root = np.sqrt(weights)[:, None]
    rows = (x * root).reshape(-1, x.shape[-1])
    prior = np.diag([1.0 / p.prior for p in parameters])
    return (np.concatenate([rows, prior])[:, active],
            np.concatenate([(y * root[:, 0]).ravel(), np.zeros(len(prior))]))


@pytest.mark.parametrize('active', [[True] * 6, [True, False, True, True, False, True]],
                         ids=['all', 'some'])
def test_solve_is_least_squares_with_priors_as_rows(problem, active):
    normal, x, y, weights, parameters = problem
    active = np.array(active)
    wanted, *_ = np.linalg.lstsq(*stacked(x, y, weights, parameters, active), rcond=None)
    found = solve(normal, weights, parameters, active)
    np.testing.assert_allclose(found[active], wanted, atol=1e-12)
    assert (found[~active] == 0.0).all()


def test_solve_leaves_what_is_known(problem):
    normal, x, y, weights, parameters = problem
    active = np.array([True, True, False, True, False, True])
    known = np.array([9.0, 9.0, 0.3, 9.0, -0.2, 9.0])
    rows, right = stacked(x, y - x @ np.where(active, 0.0, known), weights, parameters, active)
    found = solve(normal, weights, parameters, active, known)
    np.testing.assert_allclose(found[active], np.linalg.lstsq(rows, right, rcond=None)[0],
                               atol=1e-12)
    np.testing.assert_array_equal(found[~active], known[~active])


def test_solve_with_nothing_to_fit(problem):
    normal, _, _, weights, parameters = problem
    assert (solve(normal, weights, parameters, np.zeros(6, dtype=bool)) == 0.0).all()


def test_solve_keeps_bounds_and_is_the_best_within(problem):
    """Where the bound is not touched the gradient is zero; where it is, it points outwards."""
    normal, x, y, weights, parameters = problem
    every = np.ones(6, dtype=bool)
    free = solve(normal, weights, parameters, every)
    low = free + np.array([0.03, -1.0, 0.02, 0.05, -1.0, -1.0])  # three of them bind
    bounded = [Parameter(p.prior, lower) for p, lower in zip(parameters, low)]
    found = solve(normal, weights, bounded, every)
    assert (found >= low).all()
    at_bound = found == low
    assert at_bound.any() and not at_bound.all()
    rows, right = stacked(x, y, weights, parameters, every)
    gradient = rows.T @ (rows @ found - right)
    np.testing.assert_allclose(gradient[~at_bound], 0.0, atol=1e-9)
    assert (gradient[at_bound] > 0.0).all()


@pytest.mark.parametrize('memory', [0.0, 1.0, 2.5])
def test_a_correlation_time_is_that_of_the_noise(memory, rng):
    """A noise that forgets by exp(-t / memory) is alike for twice its memory."""
    period = 0.05
    keep = np.exp(-period / memory) if memory else 0.0
    noise = rng.normal(size=(60_000, 7))
    for previous, row in zip(noise, noise[1:]):
        row += keep * previous
    found = correlation_times([noise[:30_000], 2.0 + noise[30_000:]], [period] * 2)
    assert found.mean() == pytest.approx(max(2 * memory, SHORTEST), rel=0.15)

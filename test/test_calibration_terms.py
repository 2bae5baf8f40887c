"""Laws of the fit: columns are derivatives, sums are sums, and solutions are least squares."""

from baxter_dynamics_ros.core import parameters as inertial
from baxter_dynamics_ros.core.exceptions import ArgumentError
from baxter_dynamics_ros.core.presliding import Presliding
from baxter_dynamics_ros.signals.predictor import Estimate
from baxter_dynamics_ros.signals.settings import PredictorSettings
import numpy as np
import pytest

pytest.importorskip('scipy', reason='needs SciPy: pip install ".[offline]"')

from baxter_dynamics_ros.calibration.fit import residual  # noqa: E402, I100
from baxter_dynamics_ros.calibration.motion import Motion  # noqa: E402
from baxter_dynamics_ros.calibration.noise import correlation_times  # noqa: E402
from baxter_dynamics_ros.calibration.noise import SHORTEST  # noqa: E402
from baxter_dynamics_ros.calibration.normal import NormalEquations  # noqa: E402
from baxter_dynamics_ros.calibration.normal import Regressor  # noqa: E402
from baxter_dynamics_ros.calibration.normal import solve  # noqa: E402
from baxter_dynamics_ros.calibration.terms import all_terms  # noqa: E402
from baxter_dynamics_ros.calibration.terms import dahl_lengths  # noqa: E402
from baxter_dynamics_ros.calibration.terms import Links  # noqa: E402
from baxter_dynamics_ros.calibration.terms import Parameter  # noqa: E402
from baxter_dynamics_ros.calibration.terms import Sample  # noqa: E402
from baxter_dynamics_ros.calibration.terms import Tilt  # noqa: E402
from baxter_dynamics_ros.calibration.terms import Tool  # noqa: E402

# Settings to begin with: the defaults, and a calibration in which nothing is zero.
SETTINGS = {
    'defaults': {},
    'calibrated': {
        'arm': 'left', 'gravity': (0.25, -0.15, -9.80),
        'effort_model.coulomb': (0.8, 0.7, 0.3, 0.2, 0.1, 0.1, 0.05),
        'effort_model.coulomb_velocity': 0.1,
        'effort_model.viscous': (0.1,) * 7,
        'effort_model.dahl': (0.5, 1.2, 0.1, 0.1, 0.02, 0.02, 0.01),
        'effort_model.dahl_length': 0.03,
        'effort_model.bias': (0.5, -0.4, 0.3, -0.2, 0.1, -0.1, 0.05),
        'effort_model.stiffness': (0.1, 0.0, -0.2, 0.1, 0.0, 0.1, 0.0),
        'effort_model.added_inertia': (0.1, -0.1, 0.05, 0.0, 0.01, 0.0, 0.0),
        'payload.mass': 0.8, 'payload.center_of_mass': (0.02, -0.03, 0.09),
        'payload.inertia': (2e-3, 2e-3, 1e-3, 1e-4, 0.0, -1e-4)},
}
NAMES = ('bias', 'spring', 'coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness', 'inertial')


@pytest.fixture(params=SETTINGS.values(), ids=SETTINGS.keys())
def settings(request):
    """Return each of the settings to begin with, complete."""
    return PredictorSettings(request.param)


@pytest.fixture(scope='module')
def motion():
    """Return a motion that sweeps s1 beyond its spring's range, and random efforts."""
    return make_motion(300, np.random.default_rng(3))


def make_motion(n, rng):
    """Return n rows at 100 Hz: two sines a joint."""
    time = 0.01 * np.arange(n)
    amplitude = rng.uniform(0.2, 0.6, (2, 7))
    amplitude[:, 1] = 1.2, 0.5
    rate = rng.uniform(1.0, 6.0, (2, 7))  # [rad/s]
    angle = rate * time[:, None, None] + rng.uniform(0.0, 6.0, (2, 7))
    q, qd, qdd = (x.sum(1) for x in (amplitude * np.sin(angle), amplitude * rate * np.cos(angle),
                                     -amplitude * rate ** 2 * np.sin(angle)))
    return Motion('test', time, q, qd, qdd, rng.normal(0.0, 5.0, (n, 7)), q, qd)


def predicted(motion, values):
    """Return the effort (n, 7) that the node predicts with some settings [N m]."""
    settings = PredictorSettings(values)
    state = Presliding(settings.effort_model.dahl_length)
    presliding = np.array([state.update(q) for q in motion.q])
    return settings.predictor().predict(Estimate(
        (motion.time * 1e9).astype(int), motion.q.copy(), motion.qd.copy(), motion.qdd.copy(),
        None, presliding)).effort


def updated(term, settings, deviation):
    """Return the settings with a term's deviations."""
    values = dict(settings.values)
    term.update(values, deviation)
    return values


def columns(term, settings, motion):
    """Return a term's columns for all joints, (n, 7, p), zero where it says it does not act."""
    lengths = np.array(dahl_lengths(settings.effort_model))[:, None]
    sample = Sample(motion, motion.presliding(lengths), settings.arm)
    result = np.zeros((len(motion), 7, len(term.parameters)))
    for joint in range(7):
        if term.acting(joint):
            result[:, joint, term.acting(joint)] = term.columns(sample, joint)
    return result


def terms_named(name, settings):
    """Return all terms of a name: of the spring that with its shape, and that with its gain."""
    wide, narrow = (all_terms(settings, shape, constant=shape) for shape in (True, False))
    terms = [term for term in wide if term.name == name]
    return terms + [term for term in narrow if term.name == name == 'spring']


@pytest.mark.parametrize('name', NAMES)
def test_a_column_is_what_a_deviation_adds_to_the_prediction(name, settings, motion):
    before = predicted(motion, settings.values)
    terms = terms_named(name, settings)
    assert terms
    for term in terms:
        found = columns(term, settings, motion)
        start = before
        if name == 'dahl':  # its length goes with it, whatever the deviation
            start = predicted(motion, updated(term, settings, np.zeros(7)))
        for k in sorted(set().union(*(term.acting(joint) for joint in range(7)))):
            parameter = term.parameters[k]
            deviation = np.zeros(len(term.parameters))
            deviation[k] = 0.1 * parameter.prior
            added = predicted(motion, updated(term, settings, deviation)) - start
            np.testing.assert_allclose(found[..., k] * deviation[k], added, rtol=0, atol=1e-9,
                                       err_msg=parameter.name)


def test_every_term_is_tested():
    names = {term.name for term in all_terms(PredictorSettings(), True)}
    assert names == {*NAMES, 'tilt', 'payload'}


def test_stiffness_is_no_spring_at_s1():
    (term,) = terms_named('stiffness', PredictorSettings())
    assert term.acting(1) == []


def test_the_tilts_columns_are_the_derivative_of_the_prediction(settings, motion):
    found = columns(Tilt(), settings, motion)
    assert np.abs(found).max() > 0.1
    for k in range(2):
        step = 1e-4 * np.eye(2)[k]  # [m/s^2]
        upper, lower = (predicted(motion, updated(Tilt(), settings, s)) for s in (step, -step))
        np.testing.assert_allclose(found[..., k], (upper - lower) / 2e-4, rtol=0, atol=1e-7)


def test_tilt_turns_gravity_and_keeps_its_size(settings):
    before = np.array(settings.values['gravity'])
    after = np.array(updated(Tilt(), settings, np.array([0.3, -0.2]))['gravity'])
    np.testing.assert_allclose(after[:2] - before[:2], [0.3, -0.2], atol=1e-12)
    assert np.linalg.norm(after) == pytest.approx(np.linalg.norm(before))
    assert after[2] < 0.0


def test_without_gravity_there_is_no_tilt():
    assert 'tilt' not in {t.name for t in all_terms(PredictorSettings({'gravity': [0.0] * 3}), 1)}


@pytest.mark.parametrize('mass', [1.4, 0.8, 0.3])
def test_a_tools_columns_are_what_it_adds_to_the_prediction(mass, settings, motion):
    tool = Tool(settings.arm.payload)
    deviation = np.zeros(10)
    deviation[tool.mass] = mass - settings.arm.payload.mass
    deviation[list(tool.moments)] = 0.04, -0.03, 0.1
    deviation[list(tool.fixed)] = tool.second_moments(deviation)
    added = columns(tool, settings, motion) @ deviation
    values = updated(tool, settings, deviation)
    np.testing.assert_allclose(predicted(motion, settings.values) + added,
                               predicted(motion, values), rtol=0, atol=1e-9)
    assert values['payload.mass'] == pytest.approx(mass)
    assert values['payload.inertia'] == settings.values['payload.inertia']


def test_a_tool_without_mass_is_none(settings):
    tool = Tool(settings.arm.payload)
    deviation = np.zeros(10)
    deviation[tool.mass] = tool.parameters[tool.mass].lower
    deviation[list(tool.moments)] = -0.8 * np.array(settings.arm.payload.center_of_mass)
    values = updated(tool, settings, deviation)
    assert PredictorSettings(values).arm.payload.mass == 0.0


def test_the_regressor_times_the_pseudo_inertias_is_tau(arm, reference, random_states):
    q, qd, qdd = random_states(50)
    pseudo = arm.parameters.pseudo_inertia.copy()
    pseudo[-1] += arm.payload.pseudo_inertia
    tau = np.einsum('nilab,lba->ni', arm.dynamics.regressor(q, qd, qdd), pseudo)
    np.testing.assert_allclose(tau, arm.inverse_dynamics(q, qd, qdd), atol=1e-11)
    np.testing.assert_allclose(tau, reference.inverse_dynamics(q, qd, qdd), atol=1e-11)


def test_pseudo_inertias_and_bodies_are_the_same_thing(rng):
    root = rng.normal(0.0, 0.3, (20, 4, 4))
    pseudo = root @ root.swapaxes(-1, -2)
    mass, center, inertia = inertial.from_pseudo_inertia(pseudo)
    np.testing.assert_allclose(inertial.pseudo_inertia(
        inertial.inertia_about_origin(inertia, mass, center), mass, center), pseudo, atol=1e-12)
    np.testing.assert_allclose(
        inertial.inertia_tensor(inertial.inertia_elements(inertia)), inertia, atol=1e-15)


def test_links_stay_bodies_while_their_least_eigenvalue_is_positive(settings, rng):
    links = Links(settings.arm)
    for scale in np.linspace(0.05, 1.0, 20):
        deviation = rng.normal(0.0, scale, 70)
        least = links.least_eigenvalues(deviation)
        values = updated(links, settings, deviation)
        if (least > 0.0).all():
            PredictorSettings(values)  # is not refused
        else:
            with pytest.raises(ArgumentError, match='link|mass'):
                PredictorSettings(values)


def test_links_deviations_are_linear_and_do_not_depend_on_the_frame(settings, rng):
    links = Links(settings.arm)
    deviation = rng.normal(0.0, 0.1, 70)
    before = settings.arm.parameters.pseudo_inertia
    after, half = (PredictorSettings(updated(links, settings, share * deviation))
                   .arm.parameters.pseudo_inertia for share in (1.0, 0.5))
    np.testing.assert_allclose(half, 0.5 * (before + after), atol=1e-12)
    # The prior's distance is a trace, the same in every frame and unit:
    change = np.linalg.solve(before, after) - np.eye(4)
    distance = np.trace(change @ change, axis1=1, axis2=2)
    np.testing.assert_allclose(distance, (deviation.reshape(7, 10) ** 2).sum(1), rtol=1e-9)


def test_residual_is_measured_less_predicted(settings, motion):
    np.testing.assert_allclose(residual(motion, settings.values),
                               motion.effort - predicted(motion, settings.values), atol=1e-12)


@pytest.fixture(scope='module')
def long_motions():
    """Return two motions; the first is longer than what is summed at a time."""
    rng = np.random.default_rng(5)
    return make_motion(1500, rng), make_motion(400, rng)


def test_normal_equations_are_sums_and_add_up(settings, long_motions):
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


@pytest.fixture
def problem(rng):
    """Return normal equations of a random problem, its rows, weights and parameters."""
    n, p = 40, 6
    x, y = rng.normal(size=(n, 7, p)), rng.normal(size=(n, 7))
    normal = NormalEquations(np.einsum('njp,njq->jpq', x, x), np.einsum('njp,nj->jp', x, y),
                             (y ** 2).sum(0), n)
    weights = rng.uniform(0.1, 4.0, 7)
    parameters = [Parameter(f'p{k}', '-', prior) for k, prior in
                  enumerate((0.05, 0.1, 0.02, 1.0, 3.0, 0.1))]
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
    bounded = [Parameter(p.name, p.unit, p.prior, lower) for p, lower in zip(parameters, low)]
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

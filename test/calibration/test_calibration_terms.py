"""Each term's columns are what its deviations add to the node's prediction; bodies stay bodies."""

from baxter_dynamics_ros.estimation.predictor import Estimate
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model import parameters as inertial
from baxter_dynamics_ros.model.exceptions import ArgumentError
from baxter_dynamics_ros.model.presliding import Presliding
import numpy as np
import pytest

pytest.importorskip('scipy', reason='needs SciPy: pip install ".[offline]"')

from baxter_dynamics_ros.calibration.body_terms import Links, Tilt, Tool  # noqa: E402, I100
from baxter_dynamics_ros.calibration.fit import residual  # noqa: E402
from baxter_dynamics_ros.calibration.terms import all_terms, OPTIONAL, TERMS  # noqa: E402

NAMES = ('bias', 'spring', 'coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness', 'inertial')


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


def terms_named(name, settings):
    """Return all terms of a name: of the spring that with its shape, and that with its gain."""
    wide, narrow = (all_terms(settings, shape, constant=shape) for shape in (True, False))
    terms = [term for term in wide if term.name == name]
    return terms + [term for term in narrow if term.name == name == 'spring']


@pytest.mark.parametrize('name', NAMES)
def test_a_column_is_what_a_deviation_adds_to_the_prediction(name, settings, motion, columns):
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
                                       err_msg=f'{name} {k}')


def test_every_term_is_tested():
    names = {term.name for term in all_terms(PredictorSettings(), True)}
    assert names == {*TERMS, *OPTIONAL}
    assert names == {*NAMES, 'tilt', 'payload'}


def test_stiffness_is_no_spring_at_s1():
    (term,) = terms_named('stiffness', PredictorSettings())
    assert term.acting(1) == []


def test_the_tilts_columns_are_the_derivative_of_the_prediction(settings, motion, columns):
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
def test_a_tools_columns_are_what_it_adds_to_the_prediction(mass, settings, motion, columns):
    tool = Tool(settings.arm)
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


def test_a_tool_of_next_to_no_mass_is_no_longer_than_a_payload_may_be(settings):
    tool = Tool(settings.arm)
    deviation = np.zeros(10)
    deviation[tool.mass] = 0.003 - settings.arm.payload.mass
    deviation[list(tool.moments)] = 0.2, -0.2, 0.0
    payload = PredictorSettings(updated(tool, settings, deviation)).arm.payload  # not refused
    assert payload.mass == pytest.approx(0.003)


def test_a_tool_without_mass_is_none(settings):
    tool = Tool(settings.arm)
    deviation = np.zeros(10)
    deviation[tool.mass] = tool.parameters[tool.mass].lower
    deviation[list(tool.moments)] = -0.8 * np.array(settings.arm.payload.center_of_mass)
    values = updated(tool, settings, deviation)
    assert PredictorSettings(values).arm.payload.mass == 0.0


def test_pseudo_inertias_and_bodies_are_the_same_thing(rng):
    root = rng.normal(0.0, 0.3, (20, 4, 4))
    pseudo = root @ root.swapaxes(-1, -2)
    mass, center, inertia = inertial.from_pseudo_inertia(pseudo)
    np.testing.assert_allclose(inertial.pseudo_inertia(inertia, mass, center), pseudo, atol=1e-12)
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

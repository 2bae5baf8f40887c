"""Terms of a fit: columns are derivatives of the node's prediction, and links stay possible."""

from baxter_dynamics_ros.calibration.terms import all_terms, Links, OPTIONAL, TERMS, Tilt, Tool
from baxter_dynamics_ros.estimation.motion_estimator import Estimate
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.exceptions import ArgumentError
from calibration.known_robot import columns, decoupled, updated
import numpy as np
import pytest

LINEAR = {*TERMS, *OPTIONAL} - {'tilt', 'payload'}


def predicted(motion, settings):
    """Return the effort (n, 7) that the node predicts with some settings [N m]."""
    length = settings.model.effort_model.dahl_length
    return Predictor(settings).predict(Estimate(
        (motion.time * 1e9).astype(int), motion.q.copy(), motion.qd.copy(), motion.qdd.copy(),
        None, motion.presliding(length))).effort


@pytest.mark.parametrize('name', sorted(LINEAR))
def test_columns_are_differences_of_the_prediction(name, settings, motion):
    """Without crosstalk; a Dahl term also sets its length, a spring has its shape or a gain."""
    terms = [term for shape in ((True, False) if name == 'spring' else (True,))
             for term in all_terms(settings, shape, constant=shape) if term.name == name]
    assert terms
    for term in terms:
        found = columns(term, settings, motion)
        start = predicted(motion, updated(term, settings, np.zeros(len(term.prior))))
        for k in np.flatnonzero(term.acts.any(0)):
            deviation = np.zeros(len(term.prior))
            deviation[k] = 0.1 * term.prior[k]
            added = predicted(motion, updated(term, settings, deviation)) - start
            if name != 'crosstalk':
                added = decoupled(added, settings)
            np.testing.assert_allclose(found[..., k] * deviation[k], added, rtol=0, atol=1e-9,
                                       err_msg=f'{name} {k}')


def test_terms_are_those_of_the_command():
    terms = all_terms(PredictorSettings(), True)
    assert {term.name for term in terms} == {*TERMS, *OPTIONAL}
    assert not terms[-1].acts[1].any() and terms[-1].name == 'stiffness'  # s1 has the spring
    weightless = all_terms(PredictorSettings(gravity=(0.0,) * 3), True)
    assert 'tilt' not in {term.name for term in weightless}


def test_columns_of_tilt_are_derivatives_of_the_prediction(settings, motion):
    """The magnitude of gravity is preserved."""
    found = columns(Tilt(), settings, motion)
    assert np.abs(found).max() > 0.1
    for k in range(2):
        step = 1e-4 * np.eye(2)[k]  # [m/s^2]
        upper, lower = (predicted(motion, updated(Tilt(), settings, s)) for s in (step, -step))
        np.testing.assert_allclose(found[..., k], decoupled(upper - lower, settings) / 2e-4,
                                   rtol=0, atol=1e-7)
    gravity = updated(Tilt(), settings, np.array([0.3, -0.2])).gravity
    assert np.linalg.norm(gravity) == pytest.approx(np.linalg.norm(settings.gravity))
    assert gravity[2] < 0.0


@pytest.mark.parametrize('mass, moment', [
    (1.4, (0.04, -0.03, 0.1)), (0.3, (0.04, -0.03, 0.1)), (0.003, (0.2, -0.2, 0.0)),
    (0.0, None)])
def test_columns_of_a_payload_are_its_addition_to_the_prediction(mass, moment, settings, motion):
    """A payload of almost no mass is placed within the reach that the settings allow."""
    tool = Tool(settings.model.arm)
    deviation = np.zeros(10)
    deviation[tool.mass] = mass - settings.model.arm.payload.mass
    deviation[tool.moments] = moment or -0.8 * np.array(settings.payload.center_of_mass)
    deviation[tool.tied] = tool.second_moments(deviation)
    found = updated(tool, settings, deviation)
    assert found.model.arm.payload.mass == pytest.approx(mass)
    if mass > 0.1:
        added = predicted(motion, found) - predicted(motion, settings)
        np.testing.assert_allclose(columns(tool, settings, motion) @ deviation,
                                   decoupled(added, settings), rtol=0, atol=1e-9)
        assert found.payload.inertia == settings.payload.inertia


@pytest.mark.parametrize('name', ['bias', 'spring', 'tilt', 'crosstalk', 'inertial', 'payload'])
def test_reported_quantities_have_the_stated_jacobian(name, settings, rng):
    (term,) = [term for term in all_terms(settings, True) if term.name == name]
    free = np.flatnonzero(~term.tied)
    start = np.zeros(len(term.prior))
    start[free] = rng.uniform(0.05, 0.1, len(free))
    if name == 'payload':
        start[term.mass] = 1.0  # [kg]
    found = updated(term, settings, start)
    for k in free:
        step = 1e-6 * np.eye(len(term.prior))[k]
        upper, lower = (term.read(updated(term, settings, start + s)) for s in (step, -step))
        np.testing.assert_allclose(term.jacobian(found)[:, k], (upper - lower) / 2e-6, atol=1e-7)


def test_links_are_possible_while_their_least_eigenvalue_is_positive(settings, rng):
    links = Links(settings.model.arm)
    for scale in np.linspace(0.1, 1.0, 10):
        deviation = rng.normal(0.0, scale, 70)
        if (links.least_eigenvalues(deviation) > 0.0).all():
            updated(links, settings, deviation)  # is not refused
        else:
            with pytest.raises(ArgumentError, match='link|mass'):
                updated(links, settings, deviation)


def test_prior_of_links_is_a_distance_in_every_frame(settings, rng):
    links = Links(settings.model.arm)
    deviation = rng.normal(0.0, 0.1, 70)
    before = settings.model.arm.parameters.pseudo_inertia
    after = updated(links, settings, deviation).model.arm.parameters.pseudo_inertia
    change = np.linalg.solve(before, after) - np.eye(4)
    distance = np.trace(change @ change, axis1=1, axis2=2)
    np.testing.assert_allclose(distance, (deviation.reshape(7, 10) ** 2).sum(1), rtol=1e-9)

"""Dahl friction: its differential equation and its use by the predictor."""

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.effort import Presliding
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np

LENGTH = 0.02  # [rad]


def states(path, length=LENGTH):
    """Return z along a path that all joints follow."""
    presliding = Presliding(length)
    return np.array([presliding.update(np.full(7, q)) for q in path])


def test_follows_dahls_equation():
    q = 0.1 * np.sin(np.linspace(0.0, 9.0, 20001))
    z = states(q)[:, 0]
    step = np.diff(q)
    middle = 0.5 * (z[1:] + z[:-1])
    np.testing.assert_allclose(np.diff(z), step * (1 - middle * np.sign(step)) / LENGTH,
                               atol=2e-6)


def test_result_does_not_depend_on_the_step():
    np.testing.assert_allclose(states([0.0, 0.05, 0.03])[-1],
                               states([*np.linspace(0.0, 0.05, 500),
                                       *np.linspace(0.05, 0.03, 500)])[-1], atol=1e-12)


def residuals(predictor, angles, start=10 ** 18):
    """Return predicted efforts for joints that all move through ``angles`` at 100 Hz."""
    names = joint_names('right')
    velocity = np.gradient(angles) / 0.01
    result = [predictor.handle(start + 10 ** 7 * k, names, np.full(7, q), np.full(7, qd),
                               np.full(7, 1e-3))
              for k, (q, qd) in enumerate(zip(angles, velocity))]
    return np.array([step.prediction.effort for step in result if step.prediction])


def test_predictor_adds_and_resets_dahl_friction():
    dahl = np.arange(1.0, 8.0)
    angles = 0.3 + 0.1 * np.sin(2.0 * np.arange(0.0, 6.0, 0.01))
    without = PredictorSettings.from_parameters({'effort_model.crosstalk': np.zeros(49)})
    with_ = without.replace({'effort_model.dahl': dahl})
    predictor = Predictor(with_)
    friction = residuals(predictor, angles) - residuals(Predictor(without), angles)
    np.testing.assert_allclose(np.abs(friction).max(0), dahl, rtol=1e-3)
    np.testing.assert_allclose(friction / dahl, friction[:, :1] * np.ones(7), atol=1e-9)
    predictor.reset()
    again = residuals(predictor, angles, 2 * 10 ** 18) - residuals(Predictor(without), angles)
    np.testing.assert_array_equal(again[0], 0.0)


def test_predict_on_a_batch_equals_handle():
    settings = PredictorSettings.from_parameters({
        'effort_model.dahl': [0.5] * 7, 'effort_model.coulomb': [1.0] * 7,
        'effort_model.stiffness': [0.2] * 7})
    names, t = joint_names('right'), 0.01 * np.arange(300)
    q = 0.3 + 0.2 * np.sin(np.multiply.outer(t, np.arange(1.0, 8.0)))
    qd, effort = np.gradient(q, axis=0) / 0.01, 0.1 + np.cos(q)
    rows = [(10 ** 18 + 10 ** 7 * k, names, *row) for k, row in enumerate(zip(q, qd, effort))]
    one_by_one, stacked = Predictor(settings), Predictor(settings)
    predictions = [step.prediction for step in (one_by_one.handle(*row) for row in rows)
                   if step.prediction]
    estimates = [step.estimate for step in (stacked.estimate(*row) for row in rows)
                 if step.estimate]
    batch = stacked.predict(type(estimates[0])(*map(np.array, zip(*estimates))))
    for field, values in zip(batch._fields, batch):
        np.testing.assert_allclose(values, [getattr(p, field) for p in predictions], rtol=0,
                                   atol=1e-12, err_msg=field)
    assert one_by_one.counts == stacked.counts

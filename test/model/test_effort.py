"""Effort model: signs, spring at s1, friction, crosstalk, and real recordings."""

from baxter_dynamics_ros import ArgumentError, BaxterArm
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model import EffortModel, joint_names, JOINTS, Presliding, rms, S1
import numpy as np
import pytest

UNCOUPLED = [i for i, joint in enumerate(JOINTS) if joint not in ('s1', 'e1')]
LOWER, UPPER = -1.9, 1.0  # range of s1 in the spring's recordings [rad]


@pytest.fixture
def full_model(rng):
    """Return a model without a value of the default."""
    return EffortModel(spring_coefficients=np.arange(1.0, 6.0), spring_range=(-2.5, 2.5),
                       coulomb_velocity=0.2, dahl_length=0.3,
                       coulomb=np.linspace(0.1, 0.7, 7), viscous=np.linspace(0.01, 0.07, 7),
                       dahl=np.linspace(0.9, 0.3, 7), bias=np.linspace(-0.3, 0.3, 7) + 0.01,
                       stiffness=np.linspace(-0.5, 0.4, 7),
                       added_inertia=np.linspace(0.3, -0.2, 7),
                       crosstalk=rng.uniform(-0.1, 0.1, (7, 7)) * (1 - np.eye(7)))


def test_effort_is_every_term_added_and_coupled(full_model, random_states):
    model, (q, qd, qdd) = full_model, random_states(100)
    tau, z = np.tanh(random_states(100)[:2])
    own = (tau + model.bias + model.viscous * qd + model.coulomb * np.tanh(qd / 0.2)
           + model.dahl * z + model.stiffness * q + model.added_inertia * qdd)
    s1 = np.clip(q[:, S1], -2.5, 2.5)
    own[:, S1] += (1.0 + 2.0 * np.sin(s1) + 3.0 * np.cos(s1) + 4.0 * np.sin(2.0 * s1)
                   + 5.0 * np.cos(2.0 * s1))
    expected = [own[:, i] + sum(model.crosstalk[i, j] * own[:, j] for j in range(7))
                for i in range(7)]
    effort = model.effort(tau, q, qd, qdd, z)
    np.testing.assert_allclose(effort.T, expected, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(model.torque(effort, q, qd, z), tau + model.added_inertia * qdd,
                               rtol=0.0, atol=1e-12)


def test_deviation_is_the_norm_of_its_parts(random_states):
    _, qd, qdd = random_states(20)
    at_rest, velocity, acceleration = np.arange(1.0, 22.0).reshape(3, 7)
    model = EffortModel(deviation=at_rest, deviation_velocity=velocity,
                        deviation_acceleration=acceleration)
    expected = np.hypot(np.hypot(at_rest, velocity * qd), acceleration * qdd)
    np.testing.assert_allclose(model.deviation_at(qd, qdd), expected, rtol=1e-14)


def test_spring_at_s1():
    q = np.linspace(LOWER, UPPER, 59)
    function = (-5.7466 - 8.6679 * np.sin(q) + 38.3573 * np.cos(q)
                + 9.3798 * np.sin(2 * q) + 2.2237 * np.cos(2 * q))
    np.testing.assert_allclose(EffortModel().spring(_at_s1(q))[:, S1], function,
                               rtol=0.0, atol=1e-12)


@pytest.mark.parametrize('beyond, border', [(-2.1, LOWER), (1.04, UPPER)], ids=['below', 'above'])
def test_spring_is_held_beyond_its_range(beyond, border):
    np.testing.assert_array_equal(EffortModel().spring(_at_s1(beyond)),
                                  EffortModel().spring(_at_s1(border)))
    assert EffortModel().spring_is_held(_at_s1(beyond))
    assert not EffortModel().spring_is_held(_at_s1(border))


def test_rigid_is_tau(random_states):
    q, qd, tau = random_states(100)
    np.testing.assert_array_equal(EffortModel.rigid().effort(tau, q, qd, qd), tau)
    assert not EffortModel.rigid().has_spring and EffortModel().has_spring
    assert not EffortModel.rigid().spring_is_held(_at_s1([-2.1, 0.0, 1.04])).any()


def test_one_state_and_leading_axes(full_model, random_states):
    q, qd, tau = random_states(6)
    many = full_model.effort(*(x.reshape(2, 3, 7) for x in (tau, q, qd, tau)),
                             np.tanh(qd / 0.2).reshape(2, 3, 7))  # the default: steady
    assert many.shape == (2, 3, 7)
    np.testing.assert_allclose(many[1, 2], full_model.effort(tau[5], q[5], qd[5], tau[5]),
                               rtol=0.0, atol=1e-13)


@pytest.mark.parametrize('values, expected', [
    ({'spring_range': (1.0, -1.9)}, 'spring_range: expected lower < upper'),
    ({'coulomb': 0.1}, r'coulomb: expected shape \(7,\), got \(\)'),
    ({'coulomb': -np.eye(7)[2]}, r'coulomb\[2\]: expected a value in \[0, 50\] N m, got -1'),
    ({'crosstalk': np.eye(6)}, r'crosstalk: expected .*\(49,\).*, got \(6, 6\)'),
    ({'crosstalk': 0.1 * np.eye(7)}, r'crosstalk: expected a zero diagonal.* 0\.1\]\]$'),
    ({'crosstalk': 0.17 * (1 - np.eye(7))}, 'crosstalk: expected .* less than 1'),
], ids=lambda value: next(iter(value)) if isinstance(value, dict) else '')
def test_refuses_invalid_values(values, expected):
    with pytest.raises(ArgumentError, match=f'^effort_model.{expected}'):
        EffortModel(**values)


def test_arrays_are_read_only_copies():
    bias = np.zeros(7)
    model = EffortModel(bias=bias)
    bias[:] = 1.0
    np.testing.assert_array_equal(model.bias, 0.0)
    with pytest.raises(ValueError, match='read-only'):
        model.bias[0] = 1.0


def dahl(path):
    """Return Dahl's state of one joint along its positions, for a length of 0.02 rad."""
    presliding = Presliding(0.02)
    return np.array([presliding.update(np.full(7, q))[0] for q in path])


def test_presliding_follows_dahls_equation_whatever_the_step():
    q = 0.1 * np.sin(np.linspace(0.0, 9.0, 5001))
    z, step = dahl(q), np.diff(q)
    middle = 0.5 * (z[1:] + z[:-1])
    np.testing.assert_allclose(np.diff(z), step * (1 - middle * np.sign(step)) / 0.02, atol=2e-5)
    fine = [*np.linspace(0.0, 0.05, 500), *np.linspace(0.05, 0.03, 500)]
    np.testing.assert_allclose(dahl([0.0, 0.05, 0.03])[-1], dahl(fine)[-1], atol=1e-12)


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
    angles = 0.3 + 0.1 * np.sin(4.0 * np.arange(0.0, 2.0, 0.01))
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


@pytest.mark.parametrize('name', ['baxter_left_arm_tracking', 'baxter_point_to_point'])
def test_spring_and_crosstalk_explain_measured_effort(recordings, name):
    # Nearly at rest, where gravity is all the torque. Measured: 1.0 and 1.8 N m with the spring,
    # 24.5 and 27.8 without it, which is worse than predicting zero (14.1 and 14.4).
    data = np.load(recordings / f'{name}.npz')
    slow = np.abs(data['velocity']).max(axis=1) < 0.05  # rad/s
    q, effort = data['position'][slow], data['effort'][slow]
    tau, rest = BaxterArm().gravity(q), np.zeros_like(q)
    residual, without = (effort - model.effort(tau, q, rest, rest)
                         for model in (EffortModel(), EffortModel.rigid()))
    assert rms(residual)[S1] < min(2.0, rms(without)[S1] / 10)
    assert rms(without)[S1] > rms(effort)[S1]
    assert (residual.std(0) < without.std(0))[JOINTS.index('e1')]  # by crosstalk from e0
    np.testing.assert_array_equal(residual[:, UNCOUPLED], without[:, UNCOUPLED])


def _at_s1(angle):
    """Return positions (..., 7) with s1 at the given angles (...) and all others at 0.2 rad."""
    q = np.full(np.shape(angle) + (7,), 0.2)
    q[..., S1] = angle
    return q

"""Every setting: its default, its range, what refuses it by name, and what it reaches."""

from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings, SETTINGS
from baxter_dynamics_ros.model.arm import BaxterArm
from baxter_dynamics_ros.model.effort import SPRING_COEFFICIENTS
from baxter_dynamics_ros.model.exceptions import ArgumentError
from baxter_dynamics_ros.model.joints import mount
from baxter_dynamics_ros.model.parameters import paper_parameters, Payload
import numpy as np
import pytest

NUMBERS = [s for s in SETTINGS if isinstance(s.default, float)]
COUNTS = [s for s in SETTINGS if type(s.default) is int]
LISTS = [s for s in SETTINGS if isinstance(s.default, tuple)]
FLAGS = [s for s in SETTINGS if isinstance(s.default, bool)]
WORDS = [s for s in SETTINGS if s.choices]
TEXTS = [s for s in SETTINGS if isinstance(s.default, str) and not s.choices]

Q = np.array([0.3, -0.6, 0.4, 1.1, -0.5, 0.7, 0.2])
QD = np.array([0.5, -0.4, 0.3, 0.6, -0.8, 0.9, 1.0])
QDD = np.array([1.0, 2.0, -1.0, 0.5, 3.0, -2.0, 1.0])


def each(settings):
    return pytest.mark.parametrize('setting', settings, ids=lambda setting: setting.name)


def refused(setting, value):
    """Assert that the value is refused, by name."""
    with pytest.raises(ArgumentError) as caught:
        PredictorSettings({setting.name: value})
    assert setting.name in str(caught.value)


def with_element(setting, i, value) -> list:
    values = list(setting.default)
    values[i] = value
    return values


def test_every_setting_is_of_a_known_kind():
    assert len(NUMBERS + COUNTS + LISTS + FLAGS + WORDS + TEXTS) == len(SETTINGS) == len(DEFAULTS)
    assert all(setting.description for setting in SETTINGS)


def test_defaults_are_valid():
    settings = PredictorSettings()
    assert settings.values == DEFAULTS == PredictorSettings({}).values
    assert PredictorSettings(settings.values).values == DEFAULTS
    assert DEFAULTS['acceleration.cutoff'] == 5.0
    assert DEFAULTS['acceleration.velocity_lag'] == 0.014
    assert DEFAULTS['align'] is True and DEFAULTS['effort_model.enabled'] is True


def test_given_values_are_kept_and_not_changed():
    given = {'acceleration.cutoff': 8, 'gravity': [0.0, 0.0, -1.62]}
    settings = PredictorSettings(given)
    assert given == {'acceleration.cutoff': 8, 'gravity': [0.0, 0.0, -1.62]}
    assert settings.values == DEFAULTS | {'acceleration.cutoff': 8.0,
                                          'gravity': (0.0, 0.0, -1.62)}
    assert isinstance(settings.values['acceleration.cutoff'], float)


@each(NUMBERS)
def test_range_of_a_number(setting):
    span = setting.upper - setting.lower
    assert np.isfinite(span)
    for bound in (setting.lower, setting.upper):
        assert PredictorSettings({setting.name: bound}).values[setting.name] == bound
    refused(setting, setting.lower - 1e-9 * span)
    refused(setting, setting.upper + 1e-9 * span)


@each(COUNTS)
def test_range_of_a_count(setting):
    for bound in (setting.lower, setting.upper):
        assert PredictorSettings({setting.name: bound}).values[setting.name] == bound
    for value in (setting.lower - 1, setting.upper + 1, float(setting.lower), True, '2', None):
        refused(setting, value)


@each(LISTS)
def test_range_of_each_element(setting):
    span = setting.upper - setting.lower
    assert np.isfinite(span)
    for i in range(len(setting.default)):
        for bound in (setting.lower, setting.upper):
            values = with_element(setting, i, bound)
            assert setting.check(values) == tuple(values)
        refused(setting, with_element(setting, i, setting.lower - 1e-9 * span))
        refused(setting, with_element(setting, i, setting.upper + 1e-9 * span))


@each(SETTINGS)
def test_values_of_another_kind_are_refused_by_name(setting):
    for value in (None, [], {}, 1j, [None], [np.nan], object()):
        refused(setting, value)
    if setting in NUMBERS or setting in LISTS:
        for value in (np.nan, np.inf, '1.0', True, ['a']):
            refused(setting, value)
    if setting in NUMBERS:
        refused(setting, [1.0])
    if setting in FLAGS or setting in WORDS or setting in TEXTS:
        for value in (0, 1, 1.0, [True], ['right']):
            refused(setting, value)
    if setting in FLAGS:
        refused(setting, 'true')
    if setting in WORDS:
        for value in ('', 'LEFT', 'forward', True):
            refused(setting, value)
        with pytest.raises(ArgumentError) as caught:
            PredictorSettings({setting.name: 'forward'})
        assert all(choice in str(caught.value) for choice in setting.choices)
    if setting in TEXTS:
        for value in ('a\x1b[1m', 'a\nb', True):
            refused(setting, value)


@each(LISTS)
def test_wrong_length_and_elements(setting):
    for value in (setting.default[:-1], setting.default + (0.0,), [setting.default], 1.0):
        refused(setting, value)
    for bad in (np.nan, np.inf, '0', None):
        refused(setting, with_element(setting, -1, bad))


def test_unknown_name_is_refused_with_the_known_ones():
    with pytest.raises(ArgumentError) as caught:
        PredictorSettings({'acceleration.cutof': 5.0})
    assert caught.value.argument == 'acceleration.cutof'
    assert all(name in str(caught.value) for name in DEFAULTS)


@pytest.mark.parametrize('values', [
    {'payload.inertia': [1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0]},  # without mass
    {'payload.mass': 1.0, 'payload.inertia': [1e-3, 1e-3, 5e-3, 0.0, 0.0, 0.0]},
    {'payload.mass': 1.0, 'payload.inertia': [-1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0]}],
    ids=['no mass', 'triangle', 'negative'])
def test_impossible_payload_is_refused(values):
    with pytest.raises(ArgumentError, match='payload.inertia'):
        PredictorSettings(values)


@pytest.mark.parametrize('enabled', [True, False])
def test_spring_range_must_not_be_empty(enabled):
    with pytest.raises(ArgumentError, match='spring_range'):
        PredictorSettings({'effort_model.spring_range': [0.5, 0.5],
                           'effort_model.enabled': enabled})


def test_disabled_effort_model_is_tau():
    model = PredictorSettings({'effort_model.enabled': False, 'effort_model.bias': [1.0] * 7,
                               'effort_model.coulomb': [1.0] * 7}).effort_model
    tau = np.arange(7.0)
    np.testing.assert_array_equal(model.effort(tau, Q, QD, QD), tau)


def test_effort_model_has_its_settings():
    coefficients = [1.0, 2.0, 3.0, 4.0, 5.0]
    model = PredictorSettings({
        'effort_model.spring_coefficients': coefficients, 'effort_model.spring_range': [-2.5, 2.5],
        'effort_model.coulomb': np.arange(7.0), 'effort_model.coulomb_velocity': 0.2,
        'effort_model.viscous': np.arange(7.0)[::-1] / 10, 'effort_model.bias': [0.5] * 7,
        'effort_model.dahl': np.arange(7.0) / 3, 'effort_model.dahl_length': 0.3,
        'effort_model.stiffness': -np.arange(7.0) / 5,
        'effort_model.added_inertia': np.arange(7.0) / 7,
    }).effort_model
    s1, z, qdd = Q[1], np.linspace(-1.0, 1.0, 7), np.linspace(3.0, -2.0, 7)
    wanted = np.arange(7) * np.tanh(QD / 0.2) + np.arange(7)[::-1] / 10 * QD + 0.5
    wanted[1] += np.dot(coefficients, [1, np.sin(s1), np.cos(s1), np.sin(2 * s1), np.cos(2 * s1)])
    wanted += np.arange(7) * (z / 3 - Q / 5 + qdd / 7)
    np.testing.assert_allclose(model.effort(np.zeros(7), Q, QD, qdd, z), wanted, rtol=1e-12)
    assert model.dahl_length == 0.3
    assert not model.spring_is_held(np.array([0, 2.4, 0, 0, 0, 0, 0]))
    assert PredictorSettings().effort_model.spring(np.zeros(7))[1] == pytest.approx(
        np.dot(SPRING_COEFFICIENTS, [1, 0, 1, 0, 1]))


@pytest.mark.parametrize('side', ['right', 'left'])
def test_arm_has_its_settings(side):
    payload = {'mass': 1.2, 'center_of_mass': (0.03, -0.02, 0.11),
               'inertia': (3e-3, 2e-3, 2.5e-3, 3e-4, -2e-4, 1e-4)}
    arm = PredictorSettings({'arm': side, 'gravity': [1.0, 2.0, -9.0]}
                            | {f'payload.{name}': v for name, v in payload.items()}).arm
    wanted = BaxterArm(payload=Payload(**payload), gravity=(1.0, 2.0, -9.0), mount=mount(side))
    np.testing.assert_array_equal(arm.inverse_dynamics(Q, QD, QDD),
                                  wanted.inverse_dynamics(Q, QD, QDD))


def test_predictor_has_its_settings():
    predictor = PredictorSettings({'arm': 'left', 'acceleration.cutoff': 10.0,
                                   'acceleration.velocity_lag': 0.03}).predictor()
    assert predictor.stream.selector.names[0] == 'left_s0'
    delay = 0.03 + np.sqrt(2) / (2 * np.pi * 10.0)
    assert predictor.estimator.delay == pytest.approx(delay, rel=1e-12)
    assert PredictorSettings({'align': False}).predictor().estimator.delay == 0.0


@pytest.mark.parametrize('loaded', [False, True])
def test_methods_agree(loaded, rng):
    pytest.importorskip('pinocchio')
    values = {'payload.mass': 1.2, 'payload.center_of_mass': [0.03, -0.02, 0.11],
              'payload.inertia': [3e-3, 2e-3, 2.5e-3, 3e-4, -2e-4, 1e-4], 'arm': 'left',
              'gravity': [1.3, -2.1, -9.4]} if loaded else {}
    predictors = [PredictorSettings(values | {'method': method}).predictor()
                  for method in ('lagrange_euler', 'newton_euler')]
    q, stamp = Q.copy(), 10 ** 18
    for _ in range(100):
        q += rng.uniform(-0.01, 0.01, 7)
        names = predictors[0].stream.selector.names
        message = stamp, names, q, rng.normal(size=7), rng.normal(size=7)
        closed_form, recursive = (
            predictor.handle(*message).prediction for predictor in predictors)
        stamp += 10_000_000
    np.testing.assert_allclose(recursive.tau, closed_form.tau, atol=1e-12)
    np.testing.assert_allclose(recursive.residual, closed_form.residual, atol=1e-12)
    assert predictors[0].counts == predictors[1].counts


def test_links_default_to_the_papers():
    ours, paper = PredictorSettings().arm.parameters, paper_parameters()
    for name in ('d', 'a', 'alpha', 'mass', 'center_of_mass', 'inertia', 'pseudo_inertia'):
        np.testing.assert_array_equal(getattr(ours, name), getattr(paper, name))


def test_links_are_used():
    heavier = np.array(DEFAULTS['links.mass']) * 2.0
    inertia = np.array(DEFAULTS['links.inertia']) * 2.0
    settings = PredictorSettings({'links.mass': heavier, 'links.inertia': inertia})
    np.testing.assert_allclose(settings.arm.gravity(Q), 2.0 * PredictorSettings().arm.gravity(Q))
    np.testing.assert_allclose(settings.arm.inverse_dynamics(Q, QD, QD),
                               2.0 * PredictorSettings().arm.inverse_dynamics(Q, QD, QD))
    moved = np.zeros((7, 3))
    moved[3] = 0.02, -0.01, 0.03
    center = np.array(DEFAULTS['links.center_of_mass']) + moved.ravel()
    arm = PredictorSettings({'links.center_of_mass': center}).arm
    np.testing.assert_allclose(arm.parameters.center_of_mass[3],
                               paper_parameters().center_of_mass[3] + moved[3])


@pytest.mark.parametrize('name, index, value', [
    ('links.mass', 2, 0.0), ('links.inertia', 4 * 6, -0.1), ('links.inertia', 6 * 6 + 3, 0.5)])
def test_impossible_links_are_refused(name, index, value):
    values = np.array(DEFAULTS[name])
    values[index] = value
    link = index // (len(values) // 7) + 1
    with pytest.raises(ArgumentError, match=f'links: no rigid body .* of link {link}:'):
        PredictorSettings({name: values})

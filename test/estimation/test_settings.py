"""Settings: defaults, ranges, errors that name the setting, and effects."""

from dataclasses import FrozenInstanceError, replace

from baxter_dynamics_ros.estimation.settings import (AccelerationSettings, ContactSettings,
                                                     DEFAULTS, PredictorSettings, SETTINGS)
from baxter_dynamics_ros.model import ArgumentError, BaxterArm, mount, Payload
from baxter_dynamics_ros.model.parameters import paper_parameters
import numpy as np
import pytest

Q = np.array([0.3, -0.6, 0.4, 1.1, -0.5, 0.7, 0.2])
QD = np.array([0.5, -0.4, 0.3, 0.6, -0.8, 0.9, 1.0])
QDD = np.array([1.0, 2.0, -1.0, 0.5, 3.0, -2.0, 1.0])
WRONG = (None, [], {}, 1j, [None], [np.nan], object())
WRONG_BY_TYPE = {
    bool: (0, 1.0, [True], 'true'),
    str: (0, 1.0, True, ['right'], 'a\x1b[1m', 'a\nb'),
    int: (2.0, True, '2'),
    float: (np.nan, np.inf, '1.0', True, [1.0]),
    tuple: (np.nan, '1.0', True, ['a'], 1.0)}
make = PredictorSettings.from_parameters


def refused(name, value):
    """Assert that the value is refused and the error names the setting."""
    with pytest.raises(ArgumentError) as caught:
        make({name: value})
    assert name in str(caught.value)


def within(setting):
    """Return values at both ends of the range, and values just outside."""
    if not isinstance(setting.default, tuple):
        step = 1 if type(setting.default) is int else 1e-9 * (setting.upper - setting.lower)
        return (setting.lower, setting.upper), (setting.lower - step, setting.upper + step)
    step = 1e-9 * (setting.upper - setting.lower)
    inside = [(bound,) * len(setting.default) for bound in (setting.lower, setting.upper)]
    return inside, [setting.default[:i] + (bound,) + setting.default[i + 1:]
                    for i in range(len(setting.default))
                    for bound in (setting.lower - step, setting.upper + step)]


@pytest.mark.parametrize('setting', SETTINGS, ids=lambda setting: setting.name)
def test_range_and_type_of_each_setting(setting):
    assert setting.description.endswith('.')
    wrong = [*WRONG, *WRONG_BY_TYPE[type(setting.default)]]
    if isinstance(setting.default, (int, float, tuple)) and not isinstance(setting.default, bool):
        inside, outside = within(setting)
        assert np.isfinite(np.ravel(inside)).all()
        assert all(setting.check(value) == value for value in inside)
        wrong += outside
    if isinstance(setting.default, tuple):
        wrong += [setting.default[:-1], (*setting.default, 0.0), [setting.default]]
    if setting.choices:
        assert [setting.check(choice) for choice in setting.choices] == [*setting.choices]
        with pytest.raises(ArgumentError, match=', '.join(setting.choices)):
            make({setting.name: 'forward'})
    for value in wrong:
        refused(setting.name, value)


def test_parameters_are_a_view_of_the_settings(all_changed):
    assert make({}) == PredictorSettings() and make({}).parameters() == DEFAULTS
    assert make(all_changed.parameters()) == all_changed
    assert all(value != DEFAULTS[name] for name, value in all_changed.parameters().items())
    given = {'acceleration.cutoff': 8, 'gravity': [0.0, 0.0, -1.62]}
    settings = make(given)
    assert given == {'acceleration.cutoff': 8, 'gravity': [0.0, 0.0, -1.62]}
    assert settings == PredictorSettings(acceleration=AccelerationSettings(cutoff=8.0),
                                         gravity=(0.0, 0.0, -1.62))
    assert isinstance(settings.acceleration.cutoff, float)
    assert settings.model.effort_model is settings.effort_model
    crosstalk = np.reshape(all_changed.parameters()['effort_model.crosstalk'], (7, 7))
    assert replace(all_changed.effort_model, crosstalk=crosstalk) == all_changed.effort_model
    assert settings.replace({'acceleration.cutoff': 5.0}) == replace(
        settings, acceleration=AccelerationSettings())


def test_groups_are_frozen_and_check_their_values():
    with pytest.raises(FrozenInstanceError):
        PredictorSettings().acceleration.cutoff = 3.0
    with pytest.raises(ArgumentError, match='contact.samples: expected an integer'):
        ContactSettings(samples=2.5)


def test_error_of_an_unknown_name_lists_the_known_names():
    with pytest.raises(ArgumentError) as caught:
        make({'acceleration.cutof': 5.0})
    assert caught.value.argument == 'acceleration.cutof'
    assert all(name in str(caught.value) for name in DEFAULTS)


@pytest.mark.parametrize('values, name', [
    ({'payload.inertia': [1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0]}, 'payload.inertia'),  # without mass
    ({'payload.mass': 1.0, 'payload.inertia': [1e-3, 1e-3, 5e-3, 0, 0, 0]}, 'payload.inertia'),
    ({'payload.mass': 1.0, 'payload.inertia': [-1e-3, 1e-3, 1e-3, 0, 0, 0]}, 'payload.inertia'),
    ({'effort_model.spring_range': [0.5, 0.5]}, 'spring_range'),
    ({'effort_model.spring_range': [0.5, 0.5], 'effort_model.enabled': False}, 'spring_range'),
    *(({name: [value if i == index else x for i, x in enumerate(DEFAULTS[name])]},
       f'links: no rigid body .* of link {link}:')
      for name, index, value, link in (('links.mass', 2, 0.0, 3), ('links.inertia', 24, -0.1, 5),
                                       ('links.inertia', 39, 0.5, 7)))])
def test_values_that_contradict_each_other_are_refused(values, name):
    with pytest.raises(ArgumentError, match=name):
        make(values)


@pytest.mark.parametrize('side', ['right', 'left'])
def test_arm_has_its_settings(side):
    payload = {'mass': 1.2, 'center_of_mass': (0.03, -0.02, 0.11),
               'inertia': (3e-3, 2e-3, 2.5e-3, 3e-4, -2e-4, 1e-4)}
    paper = paper_parameters()
    arm = make({'arm': side, 'gravity': [1.0, 2.0, -9.0],
                'links.mass': 2.0 * paper.mass, 'links.inertia': 2.0 * np.array(
                    DEFAULTS['links.inertia'])}
               | {f'payload.{name}': value for name, value in payload.items()}).model.arm
    load, none = (BaxterArm(payload=each, gravity=(1.0, 2.0, -9.0), mount=mount(side))
                  for each in (Payload(**payload), None))
    wanted = none.inverse_dynamics(Q, QD, QDD) + load.inverse_dynamics(Q, QD, QDD)
    np.testing.assert_allclose(arm.inverse_dynamics(Q, QD, QDD), wanted, atol=1e-12)
    center = paper.center_of_mass + [0.02, -0.01, 0.03]
    moved = make({'links.center_of_mass': center.ravel()}).model.arm
    np.testing.assert_array_equal(moved.parameters.center_of_mass, center)


@pytest.mark.parametrize('loaded', [False, True])
def test_methods_agree(loaded, rng):
    pytest.importorskip('pinocchio')
    values = {'payload.mass': 1.2, 'payload.center_of_mass': [0.03, -0.02, 0.11],
              'payload.inertia': [3e-3, 2e-3, 2.5e-3, 3e-4, -2e-4, 1e-4], 'arm': 'left',
              'gravity': [1.3, -2.1, -9.4]} if loaded else {}
    closed_form, recursive = (make(values | {'method': method}).model
                              for method in ('lagrange_euler', 'newton_euler'))
    states = rng.normal(size=(3, 100, 7))
    np.testing.assert_allclose(recursive.inverse_dynamics(*states),
                               closed_form.inverse_dynamics(*states), atol=1e-11)

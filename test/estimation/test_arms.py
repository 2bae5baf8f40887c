"""The names that settings bear for one arm and for both, and what each arm gets of them."""

from baxter_dynamics_ros.estimation.arms import named_settings, per_arm
from baxter_dynamics_ros.estimation.settings import DEFAULTS, PredictorSettings
from baxter_dynamics_ros.model.exceptions import ArgumentError
from baxter_dynamics_ros.model.joints import SIDES
import pytest


@pytest.mark.parametrize('side', SIDES)
def test_one_arm_has_the_settings_by_their_own_names(side):
    assert set(named_settings(side)) == set(DEFAULTS)
    values = {'arm': side, 'payload.mass': 1.0}
    settings = per_arm(values)
    assert set(settings) == {side}
    assert settings[side].values == PredictorSettings(values).values


def test_right_is_the_default():
    assert set(per_arm({})) == {'right'}


def test_of_both_each_has_a_load_and_an_effort_of_its_own():
    values = {'arm': 'both', 'right.payload.mass': 1.0, 'left.effort_model.bias': [0.5] * 7,
              'gravity': [0.0, 0.0, -1.62]}
    settings = per_arm(values)
    assert settings['right'].values == {
        **DEFAULTS, 'arm': 'right', 'payload.mass': 1.0, 'gravity': (0.0, 0.0, -1.62)}
    assert settings['left'].values == {
        **DEFAULTS, 'arm': 'left', 'effort_model.bias': (0.5,) * 7, 'gravity': (0.0, 0.0, -1.62)}


def test_of_both_every_setting_is_there_once_or_twice():
    named = named_settings('both')
    for name in DEFAULTS:
        twice = [f'{side}.{name}' in named for side in SIDES]
        assert all(twice) != (name in named) and len(set(twice)) == 1, name
        assert all(twice) == name.startswith(('effort_model.', 'payload.', 'links.'))


@pytest.mark.parametrize('values, problem', [
    ({'arm': 'middle'}, "arm: expected one of right, left, both, got 'middle'"),
    ({'arm': 'both', 'payload.mass': 1.0},
     'payload.mass: unknown setting; with arm both say right.payload.mass or left.payload.mass'),
    ({'arm': 'right', 'right.payload.mass': 1.0}, 'right.payload.mass: unknown setting; known'),
    ({'arm': 'both', 'right.gravity': [0.0] * 3}, 'right.gravity: unknown setting; known'),
    ({'arm': 'both', 'left.payload.mass': -1.0}, 'left.payload.mass: expected a value in'),
    ({'arm': 'both', 'left.payload.inertia': [0.1] * 3 + [0.0] * 3}, 'left.payload.'),
    ({'arm': 'both', 'left.links.mass': [1.0]}, 'left.links.mass: expected shape (7,)'),
    ({'arm': 'both', 'acceleration.cutoff': -1.0}, 'acceleration.cutoff: expected'),
])
def test_what_is_refused_bears_the_name_it_was_given(values, problem):
    with pytest.raises(ArgumentError) as caught:
        per_arm(values)
    assert str(caught.value).startswith(problem)

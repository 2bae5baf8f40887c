"""Gravity in the frame of a tilted base."""

from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import gravity_in_base
import numpy as np
import pytest

DOWN = (0.0, 0.0, -9.81)


def test_directions_of_roll_and_pitch():
    x, y, z = gravity_in_base(DOWN, 0.1, 0.0)
    assert x == 0.0 and y < 0.0 and z == pytest.approx(-9.81 * np.cos(0.1))
    x, y, z = gravity_in_base(DOWN, 0.0, 0.1)
    assert x > 0.0 and y == 0.0


def test_pitch_follows_roll_about_fixed_axes(rng):
    gravity = rng.normal(size=3)
    for roll, pitch in ((0.3, -0.2), (-1.2, 0.7), (np.pi, 0.0), (0.0, 3.0), (0.0, 0.0)):
        expected = gravity_in_base(gravity_in_base(gravity, 0.0, pitch), roll, 0.0)
        np.testing.assert_allclose(gravity_in_base(gravity, roll, pitch), expected, atol=1e-14)


def test_settings_base_and_gravity_agree():
    tilted = PredictorSettings.from_parameters({'base.roll': 0.2, 'base.pitch': -0.1})
    turned = PredictorSettings(gravity=tuple(gravity_in_base(DOWN, 0.2, -0.1)))
    q = np.linspace(-1.0, 1.0, 7)
    np.testing.assert_array_equal(tilted.model.arm.gravity(q), turned.model.arm.gravity(q))
    level = PredictorSettings().model.arm.gravity(q)
    assert np.abs(tilted.model.arm.gravity(q) - level).max() > 1.0

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


@pytest.mark.parametrize('roll, pitch', [(0.3, -0.2), (-1.2, 0.7), (np.pi, 0.0), (0.0, 3.0)])
def test_against_quaternions(rng, roll, pitch):
    """The quaternion qy(pitch) qx(roll) turns base axes into level axes."""
    gravity = rng.normal(size=3)

    def product(a, b):
        return np.array([a[0] * b[0] - a[1:] @ b[1:],
                         *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])
    turn = product(np.array([np.cos(pitch / 2), 0.0, np.sin(pitch / 2), 0.0]),
                   np.array([np.cos(roll / 2), np.sin(roll / 2), 0.0, 0.0]))
    back = turn * [1, -1, -1, -1]
    np.testing.assert_allclose(
        product(product(back, np.array([0.0, *gravity])), turn)[1:],
        gravity_in_base(gravity, roll, pitch), atol=1e-14)


def test_settings_base_and_gravity_agree():
    tilted = PredictorSettings.from_parameters({'base.roll': 0.2, 'base.pitch': -0.1})
    turned = PredictorSettings(gravity=tuple(gravity_in_base(DOWN, 0.2, -0.1)))
    q = np.linspace(-1.0, 1.0, 7)
    np.testing.assert_array_equal(tilted.model.arm.gravity(q), turned.model.arm.gravity(q))
    level = PredictorSettings().model.arm.gravity(q)
    assert np.abs(tilted.model.arm.gravity(q) - level).max() > 1.0

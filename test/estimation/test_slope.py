"""Velocity from positions: exact on straight lines, its lag right, untouched by jitter."""

from baxter_dynamics_ros.estimation.motion_estimator import History
import numpy as np
import pytest


class PositionSlope(History):
    """History that keeps the lag of its slope."""

    def update(self, t, q):
        self.append(t, q, None)
        slope, self.lag = self.slope()
        return slope


SPEED = np.array([0.0, 1.0, -2.0, 0.3, 4.0, -0.01, 0.7])  # [rad/s]
START = np.array([0.4, -0.5, 0.0, 1.0, 3.0, -3.0, 0.1])  # [rad]


def irregular_stamps(n: int) -> np.ndarray:
    return np.cumsum(np.random.default_rng(1).uniform(1e-4, 0.04, n))


@pytest.mark.parametrize('stamps', [irregular_stamps(300), np.arange(50) * 0.24,
                                    np.arange(400) / 800], ids=['irregular', '4 Hz', '800 Hz'])
def test_straight_lines_are_exact(stamps):
    slope = PositionSlope()
    slope.update(stamps[0], START)
    for t in stamps[1:]:
        measured = slope.update(t, START + SPEED * (t - stamps[0]))
        np.testing.assert_allclose(measured, SPEED, atol=1e-8)


@pytest.mark.parametrize('rate, lag', [(100.0, 0.015), (400.0, 0.01625), (50.0, 0.010),
                                       (10.0, 0.050)])
def test_lag(rate, lag):
    """On an even grid the slope of a parabola is its derivative in the middle of the window."""
    slope = PositionSlope()
    for t in np.arange(60) / rate:
        measured = slope.update(t, 0.5 * SPEED * t ** 2)
    assert slope.lag == pytest.approx(lag, abs=1e-9)
    np.testing.assert_allclose(measured, SPEED * (t - lag), atol=1e-9)


def test_lag_while_the_window_fills():
    slope = PositionSlope()
    lags = []
    for t in 5.0 + 0.01 * np.arange(6):
        slope.update(t, START)
        lags.append(slope.lag)
    np.testing.assert_allclose(lags, [0.0, 0.005, 0.010, 0.015, 0.015, 0.015], atol=1e-12)


@pytest.mark.parametrize('rate, lag', [(100.0, 0.015), (200.0, 0.015)])
def test_jitter_does_not_decide_how_many_samples_are_in_the_window(rate, lag):
    slope = PositionSlope()
    stamps = np.arange(2000) / rate + np.random.default_rng(2).normal(0.0, 4e-5, 2000)
    lags = []
    for t in stamps:
        slope.update(t, START)
        lags.append(slope.lag)
    # One sample more or less would change the lag by half a period.
    assert np.abs(np.array(lags[10:]) - lag).max() < 3e-4


def test_repeated_stamp_replaces_the_sample():
    slope = PositionSlope()
    slope.update(0.0, START - 1.0)
    np.testing.assert_array_equal(slope.update(0.0, START), np.zeros(7))
    for t in (0.01, 0.02, 0.03, 0.04):
        slope.update(t, START + 5.0)
        measured = slope.update(t, START + SPEED * t)
        np.testing.assert_allclose(measured, SPEED, atol=1e-9)
    assert slope.lag == pytest.approx(0.015, abs=1e-12)

"""Accuracy of re-timed stamps: acceleration, lag, evenness and locking."""

from functools import lru_cache

from arrivals import increases, made, PATTERNS, Retiming, run
from baxter_dynamics_ros.estimation.motion_estimator import MotionEstimator
from baxter_dynamics_ros.estimation.settings import PredictorSettings
import numpy as np
from perfect_robot import sines
import pytest

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

from baxter_dynamics_ros.simulation.plant import Sensors  # noqa: E402, I100

RATES = [38.0, 100.0, 1000.0]


@lru_cache
def sensed(rate):
    """Return 12 s of times [s], and the positions and velocities (n, 7) measured then."""
    sensors, none = Sensors(), np.zeros(7)
    every = round(1000 / rate)
    q, _, _ = sines(np.arange(12000) * 0.001)
    samples = []
    for i, row in enumerate(q):
        sensors.read(row)
        if i % every == 0:
            samples.append(sensors.publish(none)[:2])
    return np.arange(len(samples)) / rate, *map(np.array, zip(*samples))


def acceleration_error(rate, stamps, since):
    """Return the RMS error [rad/s^2] of the accelerations with these stamps [s], NaN for none."""
    t, q, qd = sensed(rate)
    given = np.flatnonzero(np.isfinite(stamps))
    estimator = MotionEstimator(PredictorSettings())
    errors = []
    _, _, truth = sines(t - estimator.delay)
    for i, dt in zip(given, np.diff(stamps[given], prepend=stamps[given[0]])):
        estimate = estimator.update(0, dt, q[i], qd[i], None).estimate
        if t[i] > since and estimate is not None:
            errors.append(estimate.qdd - truth[i])
    return np.sqrt(np.mean(np.square(errors)))


@pytest.mark.parametrize('rate, pattern', [(500.0, PATTERNS[0]), *zip([50.0] * 3, PATTERNS)])
def test_acceleration_is_as_good_as_with_the_robots_stamps(pattern, rate):
    robots = made(rate, 12.0)
    arrivals = pattern(robots, seed=3)
    out, _ = run(Retiming('arrival'), arrivals)
    with_robots, with_arrivals, with_retimed = (
        acceleration_error(rate, stamps, since=4.0) for stamps in (robots, arrivals, out))
    print(f'{rate:.0f} Hz, {pattern.__name__}: {with_robots:.4f} rad/s^2, arrivals '
          f'{with_arrivals / with_robots:.1f} times that, re-timed '
          f'{with_retimed / with_robots:.3f} times')
    assert with_arrivals > 3 * with_robots
    assert with_retimed < 1.05 * with_robots


@pytest.mark.parametrize('rate', RATES)
@pytest.mark.parametrize('pattern', PATTERNS)
def test_lag_and_evenness(pattern, rate):
    t = made(rate, 12.0)
    arrivals = pattern(t, seed=4)
    retiming = Retiming('arrival')
    out, restarted = run(retiming, arrivals)
    settled = t > 5.0
    lag, delay = (out - t)[settled], (arrivals - t)[settled]
    print(f'{rate:.0f} Hz, {pattern.__name__}: delay {delay.mean() * 1e3:.1f} ms, lag '
          f'{lag.mean() * 1e3:.1f} ms, sd {lag.std() * 1e3:.2f} ms, jitter '
          f'{retiming.jitter * 1e3:.1f} ms, period {(retiming.period * rate - 1) * 1e2:+.3f} %')
    assert 0.0 < lag.mean() < delay.mean() + 5e-4
    assert lag.std() < 0.003
    assert retiming.period == pytest.approx(1 / rate, rel=0.01)
    assert 0.3 * delay.std() < retiming.jitter < 2 * delay.std()  # of the last seconds
    assert np.diff(out[settled]).min() > 0.85 / rate
    assert increases(out, restarted) and retiming.resyncs == 0


@pytest.mark.parametrize('rate', RATES)
@pytest.mark.parametrize('pattern', PATTERNS)
def test_locked_after_a_second(pattern, rate):
    errors = []
    for seed in range(2):
        t = made(rate, 1.2, seed)
        retiming = Retiming('arrival')
        first = np.flatnonzero(np.isfinite(run(retiming, pattern(t, seed))[0]))[0]
        assert 0.9 < t[first] < 1.12
        errors.append(retiming.period * rate - 1)
    print(f'period wrong by {np.sqrt(np.mean(np.square(errors))):.2%} RMS')
    assert np.abs(errors).max() < 0.06

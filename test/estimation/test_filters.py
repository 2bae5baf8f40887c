"""Butterworth derivative, history of samples, and velocity from positions."""

import weakref

from baxter_dynamics_ros.estimation.motion_estimator import ButterworthDerivative, History
import numpy as np
import pytest

CUTOFF = 5.0  # [Hz]
Q, QD = np.linspace(-1.0, 1.0, 7), np.array([0.0, 1.0, -2.0, 0.5, 4.0, -0.1, 0.3])
EFFORT, RATE = np.linspace(30.0, -5.0, 7), np.linspace(-40.0, 60.0, 7)


def run(u, dt, cutoff=CUTOFF):
    """Filter samples u (n, ...), dt (n - 1,) apart; return values and derivatives (n, ...)."""
    filter_, states = ButterworthDerivative(cutoff), []
    for sample, step in zip(u, [0.0, *dt]):
        filter_.update(0.0, step, sample)
        states.append((filter_.value, filter_.derivative))
    return tuple(map(np.array, zip(*states)))


def transfer_function(s):
    """Return the second-order Butterworth low-pass at s."""
    p = s / (2 * np.pi * CUTOFF)
    return 1 / (p ** 2 + np.sqrt(2) * p + 1)


def measured_response(frequency, period):
    """Return the complex gains to value and derivative, fitted to 4 s after 4 s of settling."""
    t = np.arange(0.0, 8.0, period)
    fit = t > 4.0
    phasor = np.exp(2j * np.pi * frequency * t)
    basis = np.stack([phasor.real, -phasor.imag], -1)[fit]
    gains = []
    for output in run(phasor.real, np.diff(t)):
        (re, im), *_ = np.linalg.lstsq(basis, output[fit], rcond=None)
        gains.append(re + 1j * im)
    return tuple(gains)


@pytest.mark.parametrize('frequency', [0.2, 2.5, 5.0, 40.0])
def test_response_at_100_hz_is_the_bilinear_one(frequency):
    period = 0.01
    s = 2j / period * np.tan(np.pi * frequency * period)  # of the trapezoidal rule
    h, jwh = measured_response(frequency, period)
    assert h == pytest.approx(transfer_function(s), abs=1e-9)
    assert jwh == pytest.approx(s * transfer_function(s), abs=1e-7)


def test_delay_is_that_of_slow_sines():
    h, jwh = measured_response(0.2, 0.01)
    w = 2 * np.pi * 0.2
    delay = ButterworthDerivative(CUTOFF).delay
    assert delay == pytest.approx(0.0450, abs=5e-5)
    assert -np.angle(h) / w == pytest.approx(delay, rel=1e-3)
    assert -np.angle(jwh / 1j) / w == pytest.approx(delay, rel=1e-3)


def test_constant_input_is_exact(rng):
    u, dt = rng.normal(size=7), 10.0 ** rng.uniform(-9, 6, 1000)
    value, derivative = run(np.tile(u, (1001, 1)), dt)
    assert (value == u).all() and (derivative == 0.0).all()


@pytest.mark.parametrize('cutoff', [0.5, 50.0])
@pytest.mark.parametrize('exponents', [(-6, 0), (-3, 6), (3, 9)], ids=['small', 'all', 'huge'])
def test_no_step_makes_it_unstable(cutoff, exponents, rng):
    dt = 10.0 ** rng.uniform(*exponents, 2000)
    value, derivative = run(rng.uniform(-1.0, 1.0, (2001, 2)), dt, cutoff)
    assert np.abs(value).max() < 10.0
    assert np.abs(derivative).max() < 10.0 * 2 * np.pi * cutoff


@pytest.mark.parametrize('cutoff', [0.5, 5.0, 50.0])
def test_every_step_is_the_trapezoidal_rule(cutoff, rng):
    w = 2 * np.pi * cutoff
    dt = rng.choice([0.01, 0.01, 0.002, 0.03], 500)  # some steps equal, some not
    u = rng.normal(size=(501, 7))
    value, derivative = run(u, dt, cutoff)

    def mean(x):
        return 0.5 * (x[1:] + x[:-1])

    dt = dt[:, None]
    np.testing.assert_allclose(np.diff(value, axis=0), dt * mean(derivative), atol=1e-13)
    np.testing.assert_allclose(np.diff(derivative, axis=0), dt * (
        w ** 2 * (mean(u) - mean(value)) - np.sqrt(2) * w * mean(derivative)), atol=1e-13 * w ** 2)


def test_zero_time_step_keeps_the_state_and_replaces_the_sample():
    u = np.array([0.0, 1.0, 9.0, 2.0, 3.0])
    value, derivative = run(u, [0.01, 0.0, 0.0, 0.01])
    np.testing.assert_array_equal(value[2:4], value[1])
    np.testing.assert_array_equal(derivative[2:4], derivative[1])
    without_the_replaced, _ = run(u[[0, 1, 3, 4]], [0.01, 0.0, 0.01])
    assert value[-1] == without_the_replaced[-1] > run(u[[0, 1, 4]], [0.01, 0.01])[0][-1]


@pytest.mark.parametrize('cutoff', [1.0, 20.0])
def test_settling_time(cutoff):
    one_percent = 0.0112  # the envelope is at 1 %; the oscillation's phase adds a tenth of that
    settling_time = ButterworthDerivative(cutoff).settling_time
    t = np.linspace(0.0, 4 * settling_time, 2001)
    _, derivative = run(t, np.diff(t), cutoff)  # starts at rest while the input moves on
    wrong = np.abs(derivative - 1.0)
    assert wrong[t >= settling_time].max() < one_percent
    assert wrong[t > 0.8 * settling_time].max() > 2 * one_percent  # no longer than needed
    value, _ = run(np.eye(1, len(t))[0], np.diff(t), cutoff)  # starts at a wrong value
    assert np.abs(value[t >= settling_time]).max() < one_percent


# ---- buffer of recent samples

def filled(stamps, without_effort=()) -> History:
    """Return a history of signals linear in time."""
    history = History()
    for i, t in enumerate(stamps):
        history.append(t, Q + QD * t, None if i in without_effort else EFFORT + RATE * t)
    return history


def test_linear_signals_are_exact(rng):
    stamps = np.cumsum(rng.uniform(1e-4, 0.05, 200))
    history = filled(stamps)
    for t in rng.uniform(stamps[-1] - 0.7, stamps[-1], 500):
        q, effort = history.at(t)
        np.testing.assert_allclose(q, Q + QD * t, atol=1e-12)
        np.testing.assert_allclose(effort, EFFORT + RATE * t, atol=1e-10)


@pytest.mark.parametrize('t, known', [(0.05, True), (0.1, True), (0.15, False), (0.2, False),
                                      (0.25, False), (0.3, True)])
def test_effort_is_missing_next_to_a_sample_without_effort(t, known):
    q, effort = filled([0.0, 0.1, 0.2, 0.3, 0.4], without_effort=[2]).at(t)
    np.testing.assert_allclose(q, Q + QD * t, atol=1e-12)
    assert (effort is not None) == known
    assert filled([1.0, 1.1]).at(1.0 - 1e-9) is None


def test_repeated_stamp_yields_the_last_of_its_samples():
    history = filled([0.0, 1.0])
    for t in (1.0, 2.0):
        history.append(t, Q + 7.0, EFFORT + 7.0)
    for t in (1.0, 1.5):
        np.testing.assert_array_equal(history.at(t), (Q + 7.0, EFFORT + 7.0))


@pytest.mark.parametrize('step, most', [(0.01, 72), (1e-9, 1024)])
def test_memory_is_bounded(step, most):
    history, samples = History(), []
    for i in range(2000):
        q = np.empty(7)
        samples.append(weakref.ref(q))
        history.append(step * i, q, None)
    assert sum(sample() is not None for sample in samples) <= most


# ---- velocity from positions

def slopes(stamps, positions):
    """Return velocities (n, 7) and their lags (n,) after each of the positions (n, 7)."""
    history, found = History(), []
    for t, q in zip(stamps, positions):
        history.append(t, q, None)
        found.append(history.slope())
    return tuple(map(np.array, zip(*found)))


@pytest.mark.parametrize('stamps', [
    np.cumsum(np.random.default_rng(1).uniform(1e-4, 0.04, 300)), np.arange(50) * 0.24,
    np.arange(400) / 800], ids=['irregular', '4 Hz', '800 Hz'])
def test_slope_of_straight_lines_is_exact(stamps):
    found, _ = slopes(stamps, Q + np.multiply.outer(stamps, QD))
    settled = stamps - stamps[0] >= 0.001
    np.testing.assert_allclose(found[settled], np.tile(QD, (settled.sum(), 1)), atol=1e-8)
    assert not found[~settled].any()


@pytest.mark.parametrize('rate, lag', [(100.0, 0.015), (400.0, 0.01625), (50.0, 0.010),
                                       (10.0, 0.050)])
def test_lag(rate, lag):
    """On an even grid the slope of a parabola is its derivative in the middle of the window."""
    t = np.arange(60) / rate
    found, lags = slopes(t, 0.5 * np.multiply.outer(t ** 2, QD))
    assert lags[-1] == pytest.approx(lag, abs=1e-9)
    np.testing.assert_allclose(found[-1], QD * (t[-1] - lag), atol=1e-9)


def test_lag_while_the_window_fills():
    _, lags = slopes(5.0 + 0.01 * np.arange(6), np.tile(Q, (6, 1)))
    np.testing.assert_allclose(lags, [0.0, 0.005, 0.010, 0.015, 0.015, 0.015], atol=1e-12)


@pytest.mark.parametrize('rate', [100.0, 200.0])
def test_jitter_does_not_change_the_number_of_samples_in_the_window(rate, rng):
    stamps = np.arange(1000) / rate + rng.normal(0.0, 4e-5, 1000)
    _, lags = slopes(stamps, np.tile(Q, (1000, 1)))
    # One sample more or less would change the lag by half a period.
    assert np.abs(lags[10:] - 0.015).max() < 3e-4

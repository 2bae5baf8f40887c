"""The filtered derivative against its transfer function, its step response and its equation."""

from baxter_dynamics_ros.estimation.butterworth import ButterworthDerivative
import numpy as np
import pytest

CUTOFF = 5.0  # [Hz]
W = 2 * np.pi * CUTOFF  # [rad/s]


def run(u: np.ndarray, dt: np.ndarray, cutoff: float = CUTOFF) -> tuple:
    """Filter samples u (n, ...), dt (n - 1,) apart; return values and derivatives (n, ...)."""
    filter_ = ButterworthDerivative(cutoff)
    filter_.reset(u[0])
    states = [(filter_.value, filter_.derivative)]
    for sample, step in zip(u[1:], dt):
        filter_.update(sample, step)
        states.append((filter_.value, filter_.derivative))
    value, derivative = zip(*states)
    return np.array(value), np.array(derivative)


def transfer_function(s: complex, cutoff: float = CUTOFF) -> complex:
    """Return the second-order Butterworth low-pass at s."""
    p = s / (2 * np.pi * cutoff)
    return 1 / (p ** 2 + np.sqrt(2) * p + 1)


def measured_response(frequency: float, period: float) -> tuple:
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


@pytest.mark.parametrize('frequency', [0.2, 1.0, 2.5, 5.0, 10.0, 40.0])
def test_response_at_100_hz_is_the_bilinear_one(frequency):
    period = 0.01
    s = 2j / period * np.tan(np.pi * frequency * period)  # what the trapezoidal rule makes of it
    h, jwh = measured_response(frequency, period)
    assert h == pytest.approx(transfer_function(s), abs=1e-9)
    assert jwh == pytest.approx(s * transfer_function(s), abs=1e-7)


@pytest.mark.parametrize('frequency', [0.2, 1.0, 2.5, 5.0, 10.0])
def test_response_at_1_khz_is_the_analytic_one(frequency):
    s = 2j * np.pi * frequency
    h, jwh = measured_response(frequency, 0.001)
    assert abs(h) == pytest.approx(1 / np.sqrt(1 + (frequency / CUTOFF) ** 4), rel=2e-3)
    assert h == pytest.approx(transfer_function(s), rel=2e-3)
    assert jwh == pytest.approx(s * transfer_function(s), rel=2e-3)


def test_delay_is_what_slow_sines_are_delayed_by():
    h, jwh = measured_response(0.2, 0.01)
    w = 2 * np.pi * 0.2
    delay = ButterworthDerivative(CUTOFF).delay
    assert delay == pytest.approx(np.sqrt(2) / W)
    assert delay == pytest.approx(0.0450, abs=5e-5)
    assert -np.angle(h) / w == pytest.approx(delay, rel=1e-3)
    assert -np.angle(jwh / 1j) / w == pytest.approx(delay, rel=1e-3)


def test_ramp_is_followed_with_the_delay_for_any_steps():
    dt = np.random.default_rng(1).uniform(0.001, 0.03, 300)
    t = np.concatenate([[0.0], np.cumsum(dt)])
    value, derivative = run(0.7 * t, dt)
    late = t > 2.0
    np.testing.assert_allclose(derivative[late], 0.7, atol=1e-12)
    np.testing.assert_allclose(value[late], 0.7 * (t[late] - np.sqrt(2) / W), atol=1e-12)


def test_step_response():
    period, n = 1e-4, 4000
    filter_ = ButterworthDerivative(CUTOFF)
    filter_.reset(0.0)
    filter_.update(1.0, 0.0)  # the step, in no time
    outputs = np.empty((n, 2))
    for i in range(n):
        filter_.update(1.0, period)
        outputs[i] = filter_.value, filter_.derivative
    tau = W / np.sqrt(2) * period * np.arange(1, n + 1)
    value = 1 - np.exp(-tau) * (np.cos(tau) + np.sin(tau))
    derivative = np.sqrt(2) * W * np.exp(-tau) * np.sin(tau)
    np.testing.assert_allclose(outputs[:, 0], value, atol=1e-5)
    np.testing.assert_allclose(outputs[:, 1], derivative, atol=1e-5 * W)


def test_derivative_is_that_of_the_value_and_both_obey_the_equation():
    rng = np.random.default_rng(2)
    dt = rng.uniform(2e-4, 8e-4, 4000)
    t = np.concatenate([[0.0], np.cumsum(dt)])
    u = np.sin(2 * np.pi * t) + 0.3 * np.sin(14.0 * t + 1.0)
    value, derivative = run(u, dt)
    slope = np.gradient(value, t)[5:-5]
    curvature = np.gradient(derivative, t)[5:-5]
    np.testing.assert_allclose(slope, derivative[5:-5], atol=1e-3)
    equation = W ** 2 * (u - value) - np.sqrt(2) * W * derivative
    np.testing.assert_allclose(curvature, equation[5:-5], atol=1e-3 * W ** 2)


def test_irregular_steps_give_what_regular_ones_give():
    def signal(t):
        return np.sin(3.0 * t) + 0.2 * np.cos(11.0 * t)

    dt = np.random.default_rng(3).uniform(0.001, 0.02, 400)
    t = np.concatenate([[0.0], np.cumsum(dt)])
    fine = np.linspace(0.0, t[-1], 20001)
    value, derivative = run(signal(t), dt)
    wanted_value, wanted_derivative = run(signal(fine), np.diff(fine))
    late = t > 0.5
    np.testing.assert_allclose(value[late], np.interp(t, fine, wanted_value)[late], atol=2e-3)
    np.testing.assert_allclose(
        derivative[late], np.interp(t, fine, wanted_derivative)[late], atol=0.03)


def test_constant_input_is_exact():
    u = np.random.default_rng(4).normal(size=7)
    dt = 10.0 ** np.random.default_rng(5).uniform(-9, 6, 1000)
    value, derivative = run(np.tile(u, (1001, 1)), dt)
    assert (value == u).all()
    assert (derivative == 0.0).all()


@pytest.mark.parametrize('cutoff', [0.5, 5.0, 50.0])
@pytest.mark.parametrize('exponents', [(-6, 0), (-3, 6), (3, 9)], ids=['small', 'all', 'huge'])
def test_no_step_makes_it_unstable(cutoff, exponents):
    rng = np.random.default_rng(6)
    dt = 10.0 ** rng.uniform(*exponents, 5000)
    value, derivative = run(rng.uniform(-1.0, 1.0, (5001, 2)), dt, cutoff)
    assert np.abs(value).max() < 10.0
    assert np.abs(derivative).max() < 10.0 * 2 * np.pi * cutoff


@pytest.mark.parametrize('cutoff', [0.5, 5.0, 50.0])
def test_every_step_is_the_trapezoidal_rule(cutoff):
    rng, w = np.random.default_rng(8), 2 * np.pi * cutoff
    dt = rng.choice([0.01, 0.01, 0.002, 0.03], 500)  # some steps alike, some not
    u = rng.normal(size=(501, 7))
    value, derivative = run(u, dt, cutoff)

    def mean(x):
        return 0.5 * (x[1:] + x[:-1])

    dt = dt[:, None]
    np.testing.assert_allclose(np.diff(value, axis=0), dt * mean(derivative), atol=1e-13)
    np.testing.assert_allclose(np.diff(derivative, axis=0), dt * (
        w ** 2 * (mean(u) - mean(value)) - np.sqrt(2) * w * mean(derivative)), atol=1e-13 * w ** 2)


def test_no_time_keeps_the_state_and_replaces_the_sample():
    once, twice = ButterworthDerivative(CUTOFF), ButterworthDerivative(CUTOFF)
    for filter_ in (once, twice):
        filter_.reset(np.zeros(7))
        filter_.update(np.ones(7), 0.01)
    value, derivative = twice.value, twice.derivative
    twice.update(np.full(7, 9.0), 0.0)
    np.testing.assert_array_equal(twice.value, value)
    np.testing.assert_array_equal(twice.derivative, derivative)
    for filter_ in (once, twice):
        filter_.update(np.full(7, 2.0), 0.0)  # the last one counts
        filter_.update(np.full(7, 3.0), 0.01)
    np.testing.assert_array_equal(twice.value, once.value)
    unreplaced = ButterworthDerivative(CUTOFF)
    unreplaced.reset(np.zeros(7))
    unreplaced.update(np.ones(7), 0.01)
    unreplaced.update(np.full(7, 3.0), 0.01)
    assert (twice.value > unreplaced.value).all()


@pytest.mark.parametrize('cutoff', [1.0, 5.0, 20.0])
def test_settling_time(cutoff):
    one_percent = 0.0112  # the envelope is at 1 %; the oscillation's phase adds a tenth of that
    settling_time = ButterworthDerivative(cutoff).settling_time
    t = np.linspace(0.0, 4 * settling_time, 4001)
    # It starts at rest while the input moves on: how wrong is the derivative, and how long?
    _, derivative = run(t, np.diff(t), cutoff)
    wrong = np.abs(derivative - 1.0)
    assert wrong[t >= settling_time].max() < one_percent
    assert wrong[t > 0.8 * settling_time].max() > 2 * one_percent  # no longer than needed
    # It starts at a wrong value.
    u = np.zeros(len(t))
    u[0] = 1.0
    value, _ = run(u, np.diff(t), cutoff)
    assert np.abs(value[t >= settling_time]).max() < one_percent


def test_reset_forgets():
    filter_ = ButterworthDerivative(CUTOFF)
    filter_.reset(np.zeros(7))
    filter_.update(np.ones(7), 0.01)
    filter_.reset(np.full(7, 2.0))
    np.testing.assert_array_equal(filter_.value, np.full(7, 2.0))
    np.testing.assert_array_equal(filter_.derivative, np.zeros(7))
    filter_.update(np.full(7, 2.0), 0.01)
    np.testing.assert_array_equal(filter_.derivative, np.zeros(7))


def test_channels_do_not_mix():
    rng = np.random.default_rng(7)
    u, dt = rng.normal(size=(50, 2, 3)), rng.uniform(0.001, 0.02, 49)
    value, derivative = run(u, dt)
    alone_value, alone_derivative = run(u[:, 1, 2], dt)
    np.testing.assert_allclose(value[:, 1, 2], alone_value, rtol=1e-14)
    np.testing.assert_allclose(derivative[:, 1, 2], alone_derivative, rtol=1e-12, atol=1e-12)

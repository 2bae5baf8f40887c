"""The filtered derivative against its transfer function, its step response and its equation."""

from baxter_dynamics_ros.estimation.motion_estimator import ButterworthDerivative
import numpy as np
import pytest

CUTOFF = 5.0  # [Hz]
W = 2 * np.pi * CUTOFF  # [rad/s]


def run(u: np.ndarray, dt: np.ndarray, cutoff: float = CUTOFF) -> tuple:
    """Filter samples u (n, ...), dt (n - 1,) apart; return values and derivatives (n, ...)."""
    filter_ = ButterworthDerivative(cutoff)
    filter_.update(0.0, 0.0, u[0])
    states = [(filter_.value, filter_.derivative)]
    for sample, step in zip(u[1:], dt):
        filter_.update(0.0, step, sample)
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


def test_delay_is_what_slow_sines_are_delayed_by():
    h, jwh = measured_response(0.2, 0.01)
    w = 2 * np.pi * 0.2
    delay = ButterworthDerivative(CUTOFF).delay
    assert delay == pytest.approx(np.sqrt(2) / W)
    assert delay == pytest.approx(0.0450, abs=5e-5)
    assert -np.angle(h) / w == pytest.approx(delay, rel=1e-3)
    assert -np.angle(jwh / 1j) / w == pytest.approx(delay, rel=1e-3)


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
        filter_.update(0.0, 0.0, np.zeros(7))
        filter_.update(0.0, 0.01, np.ones(7))
    value, derivative = twice.value, twice.derivative
    twice.update(0.0, 0.0, np.full(7, 9.0))
    np.testing.assert_array_equal(twice.value, value)
    np.testing.assert_array_equal(twice.derivative, derivative)
    for filter_ in (once, twice):
        filter_.update(0.0, 0.0, np.full(7, 2.0))  # the last one counts
        filter_.update(0.0, 0.01, np.full(7, 3.0))
    np.testing.assert_array_equal(twice.value, once.value)
    unreplaced = ButterworthDerivative(CUTOFF)
    unreplaced.update(0.0, 0.0, np.zeros(7))
    unreplaced.update(0.0, 0.01, np.ones(7))
    unreplaced.update(0.0, 0.01, np.full(7, 3.0))
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

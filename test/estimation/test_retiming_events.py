"""What can happen to times of arrival: another rate, pauses, losses, and stamps of any sort."""

from arrivals import increases, made, PATTERNS, Retiming, run, stalled
from baxter_dynamics_ros.estimation.retiming import MODES
import numpy as np
import pytest


@pytest.mark.parametrize('rates', [(400.0, 100.0), (100.0, 120.0), (38.0, 1000.0)])
@pytest.mark.parametrize('pattern', PATTERNS)
def test_another_rate(pattern, rates):
    before, after = rates
    t = np.concatenate([made(before, 10.0), 10.0 + made(after, 15.0)])
    retiming = Retiming('arrival')
    out, restarted = run(retiming, pattern(t, seed=1))
    assert retiming.resyncs == 1 and restarted.sum() == 2
    again = t[restarted][1]
    left = t[(t > 10.0) & np.isnan(out)][0]
    print(f'noticed after {left - 10:.2f} s, locked after {again - 10:.2f} s')
    assert again < 11.6 if abs(after / before - 1) > 1 else again < 12.1
    assert np.nanmax(np.abs(out - t)[t > again + 1.0]) < 0.06
    assert retiming.period == pytest.approx(1 / after, rel=0.01)
    assert increases(out, restarted)


@pytest.mark.parametrize('step', [0.3, 5.0, -0.3, -5.0, 1e9, -1e9])
def test_a_pause_or_another_clock_begins_anew(step):
    t = made(100.0, 10.0)
    arrivals = stalled(t)
    arrivals[500:] += step
    retiming = Retiming('auto')
    out, restarted = run(retiming, arrivals)
    assert retiming.retimed and retiming.resyncs == 1
    assert restarted.sum() == 3 and 590 < np.flatnonzero(restarted)[2] < 620
    lag = (out - t)[620:] - step
    assert -0.02 < lag.min() and lag.max() < 0.05
    locked = np.flatnonzero(restarted)[1]
    assert increases(out[locked:], restarted[locked:])


def test_a_long_stall_is_no_pause():
    t = made(100.0, 10.0)
    arrivals = t.copy()
    arrivals[500:520] = t[520]
    retiming = Retiming('arrival')
    out, restarted = run(retiming, arrivals)
    assert retiming.resyncs == 0 and restarted.sum() == 1
    assert np.nanmax(np.abs(out - t)) < 0.004


@pytest.mark.parametrize('start', [0, -5 * 10 ** 18, 9 * 10 ** 18, 10 ** 30])
def test_no_digit_is_lost(start):
    arrivals = stalled(made(100.0, 5.0))
    steps = [round(x * 1e9) for x in arrivals]
    wanted, found = Retiming('arrival'), Retiming('arrival')
    for step in steps:
        here, there = wanted.update(step, True), found.update(start + step, True)
        assert here is there is None or here == there - start
    assert isinstance(there, int)


def test_wild_stamps_do_no_harm():
    random = np.random.default_rng(0)
    stamps = [int(x) for x in random.integers(-2 ** 63, 2 ** 63, 500)]
    for mode in MODES:
        retiming = Retiming(mode)
        for stamp in stamps:
            retiming.update(stamp, bool(random.integers(2)))
        out, restarted = run(retiming, stalled(made(100.0, 3.0)))
        assert np.isfinite(out[150:]).all()


@pytest.mark.parametrize('seed', range(2))
def test_stamps_increase_whatever_happens(seed):
    random = np.random.default_rng(seed)
    arrivals, last = [], 0.0
    for _ in range(30):  # pieces of streams of any rate and pattern
        t = made(random.uniform(38.0, 1000.0), random.uniform(0.1, 3.0), seed)
        pattern = random.choice(PATTERNS + [lambda t, seed: t])
        arrivals.append(last + random.choice([0.0, 0.01, 0.2, -0.1, -1.0, 1.0])
                        + pattern(t, seed))
        last = arrivals[-1][-1]
    retiming = Retiming('arrival')
    out, restarted = run(retiming, np.concatenate(arrivals))
    assert increases(out, restarted)
    assert retiming.resyncs > 3

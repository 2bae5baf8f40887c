"""Recognition of times of arrival, and re-timing through changes of rate, pauses and jumps."""

from arrivals import increases, lossy, made, PATTERNS, Retiming, run, stalled, START
from baxter_dynamics_ros.estimation.retiming import MODES
import numpy as np
import pytest


# ---- which stamps are used

ROBOTS = {f'{rate:.0f} Hz': made(rate, 20.0) for rate in (38.0, 1000.0)} | {
    'a fifth lost': lossy(100.0, 0.2),
    'most lost': lossy(1000.0, 0.9),
    # 1000 Hz of which a late reader gets the last ten, every 50 ms.
    'overloaded': made(1000.0, 20.0).reshape(-1, 50)[:, 40:].ravel(),
    '100, 1000, 38 Hz': np.concatenate([made(100.0, 5.0), 5 + made(1000.0, 5.0),
                                        10 + made(38.0, 5.0)]),
    'pauses': np.concatenate([made(100.0, 1.0) + 1.37 * i for i in range(10)]),
    'clock set back': np.concatenate([made(100.0, 1.0) - 0.7 * i for i in range(10)]),
    'out of order': made(100.0, 20.0).reshape(-1, 2)[:, ::-1].ravel(),
    'two publishers, 1 ms apart': np.sort(
        np.concatenate([made(100.0, 20.0), made(100.0, 20.0, 1) + 0.001])),
}


@pytest.mark.parametrize('mode, t', [
    *(('auto', t) for t in ROBOTS.values()),
    ('header', stalled(made(100.0, 3.0))), ('header', np.tile([-9e9, 9e9], 10))],
    ids=[*ROBOTS, 'mode header', 'mode header, wild'])
def test_robots_stamps_are_used_and_all_in_mode_header(mode, t):
    retiming = Retiming(mode)
    stamps = [START + round(x * 1e9) for x in t]
    assert [retiming.update(stamp, True) for stamp in stamps] == stamps
    assert not retiming.retimed and retiming.resyncs == 0
    assert retiming.period is None and retiming.jitter is None


def test_repeated_data_are_no_evidence():
    retiming = Retiming('auto')
    for stamp in range(START, START + 10 ** 10, 10 ** 7):  # a simulation that publishes twice
        assert retiming.update(stamp, True) == stamp
        assert retiming.update(stamp, False) == stamp
        assert retiming.update(stamp + 10 ** 5, False) == stamp + 10 ** 5
        assert not retiming.retimed


def test_few_short_steps_are_no_evidence():
    # Two short steps in each hundred.
    t = made(100.0, 20.0)
    t[50::100] = t[49::100]
    t[80::100] = t[79::100]
    retiming = Retiming('auto')
    run(retiming, t)
    assert not retiming.retimed
    t[90::100] = t[89::100]
    run(retiming, t + 20.0)
    assert retiming.retimed


# ---- recognition

@pytest.mark.parametrize('rate', [38.0, 100.0, 1000.0])
@pytest.mark.parametrize('pattern', PATTERNS)
def test_arrivals_are_recognised(pattern, rate):
    recognised = []
    for seed in range(4):
        t = made(rate, 6.0, seed)
        retiming = Retiming('auto')
        for x in pattern(t, seed):
            stamp = retiming.update(START + round(x * 1e9), True)
            if retiming.retimed:
                break
            assert stamp == START + round(x * 1e9)
        assert retiming.retimed
        recognised.append(x)
    print(f'recognised after {np.median(recognised):.2f} s, at most {max(recognised):.2f} s')
    assert np.median(recognised) < 1.0
    assert max(recognised) < (1.0 if rate >= 100 else 3.0)


# ---- changes

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
def test_a_pause_or_another_clock_restarts_the_time_line(step):
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


def test_a_long_stall_of_the_receiver_does_not_restart():
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


def test_re_timing_recovers_from_wild_stamps():
    random = np.random.default_rng(0)
    stamps = [int(x) for x in random.integers(-2 ** 63, 2 ** 63, 500)]
    for mode in MODES:
        retiming = Retiming(mode)
        for stamp in stamps:
            retiming.update(stamp, bool(random.integers(2)))
        out, restarted = run(retiming, stalled(made(100.0, 3.0)))
        assert np.isfinite(out[150:]).all()


@pytest.mark.parametrize('seed', range(2))
def test_stamps_always_increase(seed):
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

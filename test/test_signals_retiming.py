"""Times of arrival are recognised and made even; the robot's own stamps never are."""

from functools import lru_cache

from baxter_dynamics_ros.signals.motion import MotionEstimator
from baxter_dynamics_ros.signals.retiming import MODES
from baxter_dynamics_ros.signals.retiming import Retiming
from baxter_dynamics_ros.simulation.sensors import Sensors
import numpy as np
import pytest

START = 1_700_000_000_123_456_789  # [ns]
JITTER = 4e-5  # sd of the robot's stamps [s]
RATES = [38.0, 50.0, 100.0, 400.0, 1000.0]


def made(rate, duration, seed=0):
    """Return when a robot stamps its messages [s]."""
    n = int(duration * rate)
    return np.arange(n) / rate + np.random.default_rng(seed).normal(0.0, JITTER, n)


def stalled(t, seed=0):
    """Return arrivals at a receiver that is away for 50 to 110 ms about three times a second."""
    random = np.random.default_rng(seed)
    n = int(4 * (t[-1] - t[0])) + 40
    lasts = random.uniform(0.05, 0.11, n)
    ends = t[0] + np.cumsum(random.exponential(0.27, n) + lasts)
    delayed = t + random.exponential(3e-4, len(t))
    i = np.searchsorted(ends, delayed)
    return np.maximum.accumulate(np.where(delayed > (ends - lasts)[i], ends[i], delayed))


def queued(t, seed=0):
    """Return arrivals over a link that delays each by 15 ms in the mean and keeps the order."""
    delays = np.random.default_rng(seed).exponential(0.015, len(t))
    return np.maximum.accumulate(t + delays)


def polled(t, seed=0):
    """Return arrivals at a receiver that looks at no regular times, 77 times a second."""
    random = np.random.default_rng(seed)
    looks = t[0] + np.cumsum(random.exponential(0.013, int(100 * (t[-1] - t[0])) + 100))
    return looks[np.searchsorted(looks, t)]


PATTERNS = [stalled, queued, polled]


def run(retiming, arrivals, fresh=True, start=START):
    """Return the stamps [s since start] handed out, NaN for None, and those that began anew."""
    out, restarted = [], []
    for x in arrivals:
        stamp = retiming.update(start + round(x * 1e9), fresh)
        out.append(np.nan if stamp is None else (stamp - start) * 1e-9)
        restarted.append(retiming.restarted)
        assert not (stamp is None and retiming.restarted)
    return np.array(out), np.array(restarted)


def increases(out, restarted):
    """Tell whether stamps increase but for where they are said to begin anew."""
    given = np.isfinite(out)
    return bool((np.diff(out[given]) > 0)[~restarted[given][1:]].all())


# ---- what is believed

@pytest.mark.parametrize('arrivals', [stalled(made(100.0, 3.0)), -np.arange(50.0), np.zeros(50),
                                      np.tile([-9e9, 9e9], 10)],
                         ids=['bursts', 'backwards', 'still', 'wild'])
def test_header_believes_everything(arrivals):
    retiming = Retiming('header')
    stamps = [round(x * 1e9) for x in arrivals]
    assert [retiming.update(stamp, True) for stamp in stamps] == stamps
    assert not retiming.retimed and retiming.period is None and retiming.jitter is None


def lossy(rate, share, seed=1):
    """Return the robot's stamps without a share of them."""
    t = made(rate, 20.0)
    return t[np.random.default_rng(seed).uniform(size=len(t)) > share]


def overloaded():
    """Return 1000 Hz of which a late reader gets the last ten, every 50 ms."""
    t = made(1000.0, 20.0)
    return t[np.arange(len(t)) % 50 >= 40]


def interleaved(offset):
    """Return the stamps of two publishers of the same arm, one ``offset`` [s] after the other."""
    return np.sort(np.concatenate([made(100.0, 20.0), made(100.0, 20.0, 1) + offset]))


ROBOTS = {f'{rate:.0f} Hz': made(rate, 20.0) for rate in RATES} | {
    'a fifth lost': lossy(100.0, 0.2),
    'most lost': lossy(1000.0, 0.9),
    'overloaded': overloaded(),
    '100, 1000, 38 Hz': np.concatenate([made(100.0, 5.0), 5 + made(1000.0, 5.0),
                                        10 + made(38.0, 5.0)]),
    'pauses': np.concatenate([made(100.0, 1.0) + 1.37 * i for i in range(10)]),
    'clock set back': np.concatenate([made(100.0, 1.0) - 0.7 * i for i in range(10)]),
    'out of order': made(100.0, 20.0).reshape(-1, 2)[:, ::-1].ravel(),
    'two publishers, 1 ms apart': interleaved(0.001),
    'two publishers, 3 ms apart': interleaved(0.003),
}


@pytest.mark.parametrize('t', ROBOTS.values(), ids=ROBOTS.keys())
def test_robots_stamps_are_believed(t):
    retiming = Retiming('auto')
    stamps = [START + round(x * 1e9) for x in t]
    assert [retiming.update(stamp, True) for stamp in stamps] == stamps
    assert not retiming.retimed and retiming.resyncs == 0


def test_first_stamp_of_a_robot_begins_the_line():
    _, restarted = run(Retiming('auto'), made(100.0, 1.0))
    assert restarted[0] and not restarted[1:].any()


def test_repeated_data_tell_nothing():
    retiming = Retiming('auto')
    for stamp in range(START, START + 10 ** 10, 10 ** 7):  # a simulation that publishes twice
        assert retiming.update(stamp, True) == stamp
        assert retiming.update(stamp, False) == stamp
        assert retiming.update(stamp + 10 ** 5, False) == stamp + 10 ** 5
        assert not retiming.retimed


def test_few_that_come_too_soon_tell_nothing():
    # Two among a hundred, again and again: one of the robot's own hiccups, or of its clock's.
    t = made(100.0, 20.0)
    t[50::100] = t[49::100]
    t[80::100] = t[79::100]
    retiming = Retiming('auto')
    run(retiming, t)
    assert not retiming.retimed
    t[90::100] = t[89::100]
    run(retiming, t + 20.0)
    assert retiming.retimed


# ---- what is recognised

@pytest.mark.parametrize('rate', RATES)
@pytest.mark.parametrize('pattern', PATTERNS)
def test_arrivals_are_recognised(pattern, rate):
    recognised = []
    for seed in range(10):
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


def test_the_pattern_is_the_one_measured():
    dt = np.diff(stalled(made(100.0, 300.0)))
    print(f'sd {dt.std() * 1e3:.1f} ms, equal stamps {np.mean(dt == 0):.2f}')
    assert dt.std() == pytest.approx(0.0138, abs=0.0004)
    assert np.mean(dt == 0) == pytest.approx(0.21, abs=0.02)


def test_withheld_between_recognition_and_lock():
    arrivals = stalled(made(100.0, 10.0))
    out, restarted = run(Retiming('auto'), arrivals)
    recognised = np.flatnonzero(np.isnan(out))
    assert 5 < recognised[0] and recognised[-1] < 105
    assert np.isnan(out[recognised[0]:recognised[-1]]).all()
    assert np.flatnonzero(restarted).tolist() == [0, recognised[-1] + 1]
    np.testing.assert_allclose(out[:recognised[0]], arrivals[:recognised[0]], atol=1e-6)


def test_late_recognition_withholds_a_moment():
    t = made(100.0, 10.0)
    t[500:] = stalled(t[500:])
    out, restarted = run(Retiming('auto'), t)
    assert np.isnan(out).sum() < 12  # until the line has passed the last arrival
    assert (np.diff(out[np.isfinite(out)]) >= 0).all()
    assert restarted.sum() == 2 and 500 < np.flatnonzero(restarted)[1] < 600


# ---- how good re-timed stamps are

_DRAW = np.random.default_rng(1)
_AMPLITUDE = _DRAW.uniform(0.05, 0.2, (3, 7))  # [rad]
_PHASE = _DRAW.uniform(0.0, 2 * np.pi, (3, 7))  # [rad]
_FREQUENCY = 2 * np.pi * np.array([[0.2], [0.5], [0.9]])  # [rad/s]


def motion(t, k):
    """Return the k-th derivative (n, 7) of a motion at times t (n,)."""
    angle = _FREQUENCY * t[:, None, None] + _PHASE
    return (_AMPLITUDE * _FREQUENCY ** k * np.sin(angle + k * np.pi / 2)).sum(-2)


@lru_cache
def sensed(rate):
    """Return 12 s of times [s], and the positions and velocities (n, 7) that are measured then."""
    sensors, none = Sensors(0.001), np.zeros(7)
    every = round(1000 / rate)
    q = motion(np.arange(12000) * 0.001, 0)
    samples = []
    for i, row in enumerate(q):
        sensors.read(row, none)
        if i % every == 0:
            samples.append(sensors.publish()[:2])
    return np.arange(len(samples)) / rate, *map(np.array, zip(*samples))


def acceleration_error(rate, stamps, since):
    """Return the RMS error [rad/s^2] of the accelerations with these stamps [s], NaN for none."""
    t, q, qd = sensed(rate)
    given = np.flatnonzero(np.isfinite(stamps))
    estimator = MotionEstimator(5.0, 0.014, align=True)
    errors = []
    truth = motion(t - estimator.delay, 2)
    for i, dt in zip(given, np.diff(stamps[given], prepend=stamps[given[0]])):
        estimate = estimator.update(dt, q[i], qd[i], None)
        if t[i] > since and estimate is not None:
            errors.append(estimate.qdd - truth[i])
    return np.sqrt(np.mean(np.square(errors)))


@pytest.mark.parametrize('rate', [50.0, 100.0, 500.0])
@pytest.mark.parametrize('pattern', PATTERNS)
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


@pytest.mark.parametrize('pattern', PATTERNS)
def test_acceleration_soon_after_the_lock(pattern):
    robots = made(100.0, 12.0)
    ratios = []
    for seed in range(5):
        out, _ = run(Retiming('arrival'), pattern(robots, seed))
        out[400:] = np.nan
        ratios.append(acceleration_error(100.0, out, since=0.0)
                      / acceleration_error(100.0, robots[:400], since=1.2))
    print(f'{pattern.__name__}, the first 3 s: {np.mean(ratios):.2f}, at most {max(ratios):.2f}')
    assert max(ratios) < 1.5


@pytest.mark.parametrize('rate', RATES)
@pytest.mark.parametrize('pattern', PATTERNS)
def test_lag_and_evenness(pattern, rate):
    t = made(rate, 20.0)
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


def test_even_stamps_stay_what_they_are():
    t = made(100.0, 20.0)
    out, _ = run(Retiming('arrival'), t)
    assert np.nanmax(np.abs(out - t)) < 5 * JITTER


@pytest.mark.parametrize('rate', RATES)
@pytest.mark.parametrize('pattern', PATTERNS)
def test_locked_after_a_second(pattern, rate):
    errors = []
    for seed in range(10):
        t = made(rate, 1.2, seed)
        retiming = Retiming('arrival')
        first = np.flatnonzero(np.isfinite(run(retiming, pattern(t, seed))[0]))[0]
        assert 0.9 < t[first] < 1.12
        errors.append(retiming.period * rate - 1)
    print(f'period wrong by {np.sqrt(np.mean(np.square(errors))):.2%} RMS')
    assert np.abs(errors).max() < 0.06


def test_a_slow_stream_takes_longer():
    out, _ = run(Retiming('arrival'), made(8.0, 5.0))
    assert np.flatnonzero(np.isfinite(out))[0] == 19


def test_begins_with_the_last_of_those_that_waited():
    arrivals = made(100.0, 3.0)
    arrivals[:21] = arrivals[20]  # 0.2 s
    retiming = Retiming('arrival')
    out, _ = run(retiming, arrivals)
    assert retiming.period == pytest.approx(0.01, rel=1e-3)
    assert np.nanmax(np.abs(out - arrivals)) < 5 * JITTER


# ---- what can happen to a stream

@pytest.mark.parametrize('rates', [(100.0, 400.0), (400.0, 100.0), (100.0, 120.0), (38.0, 1000.0)])
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


@pytest.mark.parametrize('pattern', PATTERNS)
def test_a_slightly_other_rate_is_followed(pattern):
    t = np.concatenate([made(100.0, 10.0), 10.0 + made(101.0, 20.0)])
    retiming = Retiming('arrival')
    out, restarted = run(retiming, pattern(t))
    assert retiming.resyncs == 0 and restarted.sum() == 1
    assert retiming.period == pytest.approx(1 / 101.0, rel=0.005)


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


def test_a_shorter_pause_is_noticed():
    t = made(100.0, 10.0)
    t[500:] += 0.15
    retiming = Retiming('arrival')
    out, restarted = run(retiming, stalled(t))
    assert retiming.resyncs == 1
    left = np.flatnonzero(np.isnan(out[500:]))[0]
    assert left < 40
    assert np.abs((out - t)[650:]).max() < 0.03


def test_a_long_stall_is_no_pause():
    t = made(100.0, 10.0)
    arrivals = t.copy()
    arrivals[500:520] = t[520]
    retiming = Retiming('arrival')
    out, restarted = run(retiming, arrivals)
    assert retiming.resyncs == 0 and restarted.sum() == 1
    assert np.nanmax(np.abs(out - t)) < 0.004


def test_lost_messages_are_caught_up():
    t = np.delete(made(100.0, 20.0), [500, 600, 601, 602, 603])
    retiming = Retiming('arrival')
    out, restarted = run(retiming, stalled(t))
    lag = out - t
    print(f'lag after 4 lost at once {lag[600:610].mean() * 1e3:.1f} ms, later '
          f'{lag[1500:].mean() * 1e3:.1f} ms')
    assert retiming.resyncs == 0 and increases(out, restarted)
    assert lag[600:610].mean() < -0.02
    assert 0.0 < lag[1500:].mean() < 0.01


def test_steady_loss_is_another_period():
    t = lossy(100.0, 0.02)
    retiming = Retiming('arrival')
    out, restarted = run(retiming, stalled(t))
    assert retiming.period == pytest.approx(0.01 / 0.98, rel=0.02)
    assert retiming.resyncs == 0 and increases(out, restarted)


@pytest.mark.parametrize('mode', ['auto', 'arrival'])
def test_stamps_that_stand_still_give_none(mode):
    out, _ = run(Retiming(mode), np.zeros(2000))
    assert np.isnan(out[4:]).all()


def test_stamps_that_stop_are_left():
    t = made(100.0, 8.0)
    t[300:500] = t[300]
    retiming = Retiming('arrival')
    out, restarted = run(retiming, t)
    assert np.isnan(out[330:500]).all()
    assert np.nanmax(np.abs(out - t)[500:]) < 1e-3 and np.isfinite(out[620:]).all()


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


@pytest.mark.parametrize('seed', range(5))
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


def test_the_same_message_again_changes_nothing():
    arrivals = stalled(made(100.0, 3.0))
    once, twice = Retiming('arrival'), Retiming('arrival')
    for x in arrivals:
        stamp = START + round(x * 1e9)
        wanted = once.update(stamp, True)
        assert twice.update(stamp, True) == wanted
        restarted = twice.restarted
        assert restarted == once.restarted
        for _ in range(2):
            assert twice.update(stamp, False) == wanted
            assert not twice.restarted


def test_reset_forgets_everything():
    arrivals = stalled(made(100.0, 4.0))
    for mode in MODES:
        retiming = Retiming(mode)
        wanted = run(retiming, arrivals)
        run(retiming, arrivals)  # the clock is set back: a resync
        assert retiming.resyncs == (mode != 'header')
        retiming.reset()
        assert retiming.retimed == (mode == 'arrival')
        assert retiming.resyncs == 0 and retiming.period is None
        np.testing.assert_array_equal(run(retiming, arrivals), wanted)

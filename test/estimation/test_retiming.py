"""Times of arrival are recognised; the robot's own stamps never are."""

from arrivals import lossy, made, PATTERNS, Retiming, run, stalled, START
import numpy as np
import pytest

RATES = [38.0, 50.0, 100.0, 400.0, 1000.0]


# ---- what is believed

@pytest.mark.parametrize('arrivals', [stalled(made(100.0, 3.0)), -np.arange(50.0), np.zeros(50),
                                      np.tile([-9e9, 9e9], 10)],
                         ids=['bursts', 'backwards', 'still', 'wild'])
def test_header_believes_everything(arrivals):
    retiming = Retiming('header')
    stamps = [round(x * 1e9) for x in arrivals]
    assert [retiming.update(stamp, True) for stamp in stamps] == stamps
    assert not retiming.retimed and retiming.period is None and retiming.jitter is None


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


def test_withheld_between_recognition_and_lock():
    arrivals = stalled(made(100.0, 10.0))
    out, restarted = run(Retiming('auto'), arrivals)
    recognised = np.flatnonzero(np.isnan(out))
    assert 5 < recognised[0] and recognised[-1] < 105
    assert np.isnan(out[recognised[0]:recognised[-1]]).all()
    assert np.flatnonzero(restarted).tolist() == [0, recognised[-1] + 1]
    np.testing.assert_allclose(out[:recognised[0]], arrivals[:recognised[0]], atol=1e-6)

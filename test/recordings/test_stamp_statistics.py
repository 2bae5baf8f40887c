"""The robot's own stamps are distinguished from times of arrival."""

from baxter_dynamics_ros.recordings.stamp_statistics import StampClock
import numpy as np
import pytest

START = 10**18  # [ns]


def statistics(times):
    """Return the statistics of times [s], taken in blocks."""
    clock = StampClock()
    stamps = START + np.rint(np.asarray(times) * 1e9).astype(np.int64)
    steps = np.diff(times, prepend=times[0])
    axis = np.concatenate([clock.elapsed(*blocks) for blocks in zip(
        np.array_split(stamps, 3), np.array_split(steps, 3))])
    np.testing.assert_allclose(axis, times - times[0], atol=1e-6)
    return clock.result()


@pytest.mark.parametrize('lose, lost', [
    (lambda t, rng: t, 0),
    (lambda t, rng: np.delete(t, slice(500, 517)), 17),  # a gap of 180 ms
    (lambda t, rng: np.delete(t, rng.choice(np.arange(1, 2199), 600, replace=False)), 600),
    (lambda t, rng: np.delete(t, np.arange(1, 2199, 2)), 0),  # every other: half the rate
    (lambda t, rng: np.delete(t, slice(500, 600)), 0),  # a pause
], ids=['none', 'one gap', 'a quarter', 'every other', 'pause'])
def test_robots_stamps_lie_on_a_grid(rng, lose, lost):
    t = 0.01 * np.arange(2200)
    times = lose(t, rng)
    found = statistics(times + 4e-5 * rng.normal(size=len(times)))
    assert found.irregularity < 0.02
    assert abs(found.lost - lost) <= 0.02 * lost
    assert found.duration == pytest.approx(22.0, abs=1.1)


def test_times_of_arrival_lie_on_no_grid(rng):
    bursts = np.sort(0.01 * np.arange(2200) + rng.exponential(0.0138, 2200))
    assert statistics(bursts).irregularity > 0.2
    jitter = 0.01 * np.arange(2200) + rng.normal(0.0, 0.002, 2200)
    assert statistics(jitter).irregularity > 0.15


def test_few_stamps_have_no_period():
    assert statistics(np.array([0.0, 0.3, 0.31])) == (pytest.approx(0.01), pytest.approx(100.0),
                                                      0.0, 0.0, 0)

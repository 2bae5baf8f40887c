"""The buffer of recent samples: exact between samples, absent before, and bounded."""

from collections import deque
import weakref

from baxter_dynamics_ros.estimation.motion_estimator import History
import numpy as np
import pytest

Q, QD = np.linspace(-1.0, 1.0, 7), np.array([0.0, 1.0, -2.0, 0.5, 4.0, -0.1, 0.3])
EFFORT, RATE = np.linspace(30.0, -5.0, 7), np.linspace(-40.0, 60.0, 7)


def filled(stamps, without_effort=()) -> History:
    """Return a line that holds signals linear in time."""
    line = History()
    for i, t in enumerate(stamps):
        line.append(t, Q + QD * t, None if i in without_effort else EFFORT + RATE * t)
    return line


def test_linear_signals_are_exact():
    rng = np.random.default_rng(1)
    stamps = np.cumsum(rng.uniform(1e-4, 0.05, 200))
    line = filled(stamps)
    for t in rng.uniform(stamps[-1] - 0.7, stamps[-1], 500):
        q, effort = line.at(t)
        np.testing.assert_allclose(q, Q + QD * t, atol=1e-12)
        np.testing.assert_allclose(effort, EFFORT + RATE * t, atol=1e-10)


def test_nothing_before_the_first():
    line = filled([1.0, 1.01])
    assert line.at(0.0) is None
    assert line.at(1.0 - 1e-9) is None
    assert line.at(1.0) is not None


@pytest.mark.parametrize('t, known', [(0.05, True), (0.1, True), (0.15, False), (0.2, False),
                                      (0.25, False), (0.3, True), (0.35, True)])
def test_effort_is_missing_on_either_side_of_the_sample_without(t, known):
    q, effort = filled([0.0, 0.1, 0.2, 0.3, 0.4], without_effort=[2]).at(t)
    np.testing.assert_allclose(q, Q + QD * t, atol=1e-12)
    if known:
        np.testing.assert_allclose(effort, EFFORT + RATE * t, atol=1e-12)
    else:
        assert effort is None


def test_repeated_stamp_yields_the_last_of_its_samples():
    line = filled([0.0, 1.0])
    line.append(1.0, Q + 7.0, EFFORT + 7.0)
    line.append(2.0, Q + 7.0, EFFORT + 7.0)
    for t in (1.0, 1.5):
        q, effort = line.at(t)
        np.testing.assert_array_equal(q, Q + 7.0)
        np.testing.assert_array_equal(effort, EFFORT + 7.0)


def test_reset_forgets():
    line = filled([0.0, 1.0])
    line.reset()
    line.append(1.5, Q, EFFORT)
    assert line.at(1.25) is None


def test_memory_is_bounded_in_a_long_stream():
    line, alive, most = History(), deque(), 0
    for i in range(20_000):
        q = Q
        if i % 10 == 0:
            q = Q.copy()
            alive.append(weakref.ref(q))
            while alive[0]() is None:
                alive.popleft()
            most = max(most, len(alive))
        line.append(0.01 * i, q, None)
    assert most <= 8  # 0.7 s


def test_memory_is_bounded_where_stamps_are_not_filled_in():
    line, samples = History(), []
    for i in range(4000):
        q = np.empty(7)
        samples.append(weakref.ref(q))
        line.append(1e-9 * (i // 2), q, None)
    assert sum(sample() is not None for sample in samples) <= 1024

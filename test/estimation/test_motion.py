"""The estimated motion on known ones: aligned, it is that of its instant; otherwise it lags."""

import weakref

from baxter_dynamics_ros.estimation.motion_estimator import MotionEstimator
import numpy as np
import pytest

VELOCITY_LAG = 0.014  # [s]
FILTER_DELAY = np.sqrt(2) / (2 * np.pi * 5.0)  # [s]
SETTLED = np.log(100.0) * np.sqrt(2) / (2 * np.pi * 5.0)  # [s]

_RNG = np.random.default_rng(1)
_AMPLITUDE = _RNG.uniform(0.05, 0.2, (3, 7))  # [rad]
_PHASE = _RNG.uniform(0.0, 2 * np.pi, (3, 7))  # [rad]
_FREQUENCY = 2 * np.pi * np.array([[0.2], [0.5], [0.9]])  # [rad/s]


def trajectory(t: np.ndarray) -> tuple:
    """Return q, qd, qdd (n, 7) at times t (n,): sums of three sines."""
    angle = _FREQUENCY * np.asarray(t)[:, None, None] + _PHASE
    return tuple((_AMPLITUDE * _FREQUENCY ** k * np.sin(angle + k * np.pi / 2)).sum(-2)
                 for k in range(3))


def effort(t: np.ndarray) -> np.ndarray:
    """Return what is measured at times t (n,), shape (n, 7): any smooth signal."""
    return 30.0 * trajectory(t)[0] + 4.0


def stamps(rate: float, jitter: float = 0.0) -> np.ndarray:
    """Return 6 s of stamps whose steps vary by ``jitter`` of the period."""
    n = int(6 * rate)
    steps = 1 + jitter * np.random.default_rng(2).uniform(-1.0, 1.0, n)
    return 100.0 + np.cumsum(steps) / rate


STAMPS = {'50 Hz': stamps(50.0), '100 Hz': stamps(100.0), '400 Hz': stamps(400.0),
          '0.04 ms jitter': stamps(100.0, 0.004), 'half a period of jitter': stamps(100.0, 0.5)}


def estimate(t, estimator, measures_velocity=True, measures_effort=True) -> tuple:
    """Return the stamps (m,) at which there were estimates, and those, m in number."""
    q = trajectory(t)[0]
    qd = trajectory(t - VELOCITY_LAG)[1] if measures_velocity else [None] * len(t)
    efforts = effort(t) if measures_effort else [None] * len(t)
    motions = [estimator.update(*row).accelerated
               for row in zip(np.diff(t, prepend=t[0]), q, qd, efforts)]
    given = [motion is not None for motion in motions]
    return t[given], [motion for motion in motions if motion is not None]


def error(motions, name: str, wanted: np.ndarray) -> float:
    """Return the RMS error over that of the wanted (m, 7)."""
    found = np.array([getattr(motion, name) for motion in motions])
    return np.sqrt(np.mean((found - wanted) ** 2) / np.mean(wanted ** 2))


@pytest.mark.parametrize('t', STAMPS.values(), ids=STAMPS.keys())
def test_aligned_estimate_is_the_motion_at_its_instant(t):
    now, motions = estimate(t, MotionEstimator(5.0, VELOCITY_LAG, align=True))
    np.testing.assert_allclose([motion.delay for motion in motions], VELOCITY_LAG + FILTER_DELAY)
    then = now - (VELOCITY_LAG + FILTER_DELAY)
    q, qd, qdd = trajectory(then)
    assert error(motions, 'q', q) < 1e-3
    assert error(motions, 'qd', qd) < 4e-3
    assert error(motions, 'qdd', qdd) < 5e-3
    assert error(motions, 'effort', effort(then)) < 1e-3


def test_unaligned_estimate_has_the_newest_values():
    estimator = MotionEstimator(5.0, VELOCITY_LAG, align=False)
    assert estimator.delay == 0.0
    now, motions = estimate(STAMPS['100 Hz'], estimator)
    assert {motion.delay for motion in motions} == {0.0}
    for i in (0, 250, -1):
        np.testing.assert_array_equal(motions[i].q, trajectory(now)[0][i])
        np.testing.assert_array_equal(motions[i].qd, trajectory(now - VELOCITY_LAG)[1][i])
        np.testing.assert_array_equal(motions[i].effort, effort(now)[i])
    lagging = trajectory(now - VELOCITY_LAG - FILTER_DELAY)[2]
    assert error(motions, 'qdd', lagging) < 1e-2


@pytest.mark.parametrize('name, align', [('100 Hz', False), ('half a period of jitter', True)])
def test_estimates_are_withheld_until_settled(name, align):
    t, estimator = STAMPS[name], MotionEstimator(5.0, VELOCITY_LAG, align)
    now, _ = estimate(t, estimator)
    assert estimator.settling_time == pytest.approx(SETTLED, rel=1e-12)
    np.testing.assert_array_equal(now, t[t - t[0] >= SETTLED])
    estimator.reset()
    again, _ = estimate(t, estimator)
    np.testing.assert_array_equal(again, now)


def test_estimates_are_withheld_until_history_reaches_back():
    estimator = MotionEstimator(50.0, 0.2, align=True)
    now, _ = estimate(STAMPS['100 Hz'], estimator)
    assert estimator.settling_time == estimator.delay > 0.2
    assert now[0] - STAMPS['100 Hz'][0] >= estimator.delay
    assert now[0] - STAMPS['100 Hz'][0] < estimator.delay + 0.011


@pytest.mark.parametrize('t, lag', [(STAMPS['100 Hz'], 0.015), (STAMPS['400 Hz'], 0.01625),
                                    (STAMPS['50 Hz'], 0.010)], ids=['100 Hz', '400 Hz', '50 Hz'])
def test_missing_velocity_is_the_slope_of_the_positions(t, lag):
    estimator = MotionEstimator(5.0, VELOCITY_LAG, align=True)
    now, motions = estimate(t, estimator, measures_velocity=False)
    delays = np.array([motion.delay for motion in motions])
    np.testing.assert_allclose(delays, lag + FILTER_DELAY, atol=1e-9)
    late = now > t[0] + 1.0  # the slope begins at zero: a jump, which decays
    q, qd, qdd = trajectory((now - delays)[late])
    motions = [motion for motion, is_late in zip(motions, late) if is_late]
    assert error(motions, 'q', q) < 1e-3
    assert error(motions, 'qd', qd) < 4e-3
    assert error(motions, 'qdd', qdd) < 5e-3


def test_missing_effort_stays_missing():
    _, motions = estimate(STAMPS['100 Hz'], MotionEstimator(5.0, VELOCITY_LAG, True),
                          measures_effort=False)
    assert motions and all(motion.effort is None for motion in motions)


@pytest.mark.parametrize('align', [True, False])
def test_repeated_stamp_gives_no_estimate(align):
    estimator = MotionEstimator(5.0, VELOCITY_LAG, align)
    estimate(STAMPS['100 Hz'], estimator)
    q, qd, _ = (array[0] for array in trajectory(STAMPS['100 Hz'][-1:]))
    assert estimator.update(0.0, q, qd, None).accelerated is None
    assert estimator.update(0.01, q, qd, None).accelerated is not None


def test_velocity_is_aligned_with_position_and_effort_of_its_instant():
    t = STAMPS['100 Hz'] - STAMPS['100 Hz'][0]
    estimator = MotionEstimator(5.0, VELOCITY_LAG, align=False)
    for row in zip(np.diff(t, prepend=0.0), trajectory(t)[0], trajectory(t - VELOCITY_LAG)[1],
                   effort(t)):
        found = estimator.update(*row)
    assert found.lag == VELOCITY_LAG and found.t == pytest.approx(t[-1] - VELOCITY_LAG, abs=1e-9)
    wanted = *trajectory(t[-1:] - VELOCITY_LAG)[:2], effort(t[-1:] - VELOCITY_LAG)
    for x, y in zip((found.q, found.qd, found.effort), wanted):
        np.testing.assert_allclose(x, y[0], atol=1e-2)


@pytest.mark.parametrize('align, dt', [(True, 0.01), (False, 0.01), (True, 0.0), (False, 0.0)])
def test_memory_is_bounded(align, dt):
    estimator, samples = MotionEstimator(5.0, VELOCITY_LAG, align), []
    for _ in range(2000):
        q = np.zeros(7)
        samples.append(weakref.ref(q))
        estimator.update(dt, q, np.zeros(7), None)
    assert sum(sample() is not None for sample in samples) < 100

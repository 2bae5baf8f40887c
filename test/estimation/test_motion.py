"""Motion estimator on known trajectories: all signals describe one instant and band."""

from baxter_dynamics_ros.estimation.motion_estimator import MotionEstimator
from baxter_dynamics_ros.estimation.settings import AccelerationSettings, PredictorSettings
import numpy as np
from perfect_robot import sines as trajectory, VELOCITY_LAG
import pytest

W = 2 * np.pi * 5.0  # cutoff [rad/s]
FILTER_DELAY = np.sqrt(2) / W  # [s]
SETTLED = np.log(100.0) * np.sqrt(2) / W  # [s]


def effort(t: np.ndarray) -> np.ndarray:
    """Return a smooth measured effort of shape (n, 7) at times t (n,)."""
    return 30.0 * trajectory(t)[0] + 4.0


def stamps(rate: float, jitter: float = 0.0) -> np.ndarray:
    """Return 6 s of stamps whose steps vary by ``jitter`` of the period."""
    n = int(6 * rate)
    steps = 1 + jitter * np.random.default_rng(2).uniform(-1.0, 1.0, n)
    return 100.0 + np.cumsum(steps) / rate


STAMPS = {'50 Hz': stamps(50.0), '100 Hz': stamps(100.0), '400 Hz': stamps(400.0),
          '0.04 ms jitter': stamps(100.0, 0.004), 'half a period of jitter': stamps(100.0, 0.5)}
T = STAMPS['100 Hz']


def new(lag=VELOCITY_LAG, cutoff=5.0, **settings):
    """Return a new estimator."""
    return MotionEstimator(PredictorSettings(
        acceleration=AccelerationSettings(cutoff, lag), **settings))


def play(t, estimator, q=None, qd=None, efforts=None):
    """Return the estimates (or None) at stamps t of these signals, (n, 7) each or None."""
    rows = [[None] * len(t) if signal is None else signal for signal in (q, qd, efforts)]
    if q is None:
        rows[0] = np.zeros((len(t), 7))
    return [estimator.update(round(stamp * 1e9), *row).estimate
            for stamp, *row in zip(t, np.diff(t, prepend=t[0]), *rows)]


def estimate(t, estimator, measures_velocity=True) -> tuple:
    """Return the stamps (m,) with estimates of the trajectory, and those estimates."""
    motions = play(t, estimator, trajectory(t)[0],
                   trajectory(t - VELOCITY_LAG)[1] if measures_velocity else None, effort(t))
    given = [motion is not None for motion in motions]
    return t[given], [motion for motion in motions if motion is not None]


def delays(now, motions):
    """Return the time from the instants of estimates to the stamps of their messages [s]."""
    return now - np.array([motion.stamp_ns for motion in motions]) * 1e-9


def error(motions, name: str, wanted: np.ndarray) -> float:
    """Return the RMS error over that of the wanted (m, 7)."""
    found = np.array([getattr(motion, name) for motion in motions])
    return np.sqrt(np.mean((found - wanted) ** 2) / np.mean(wanted ** 2))


@pytest.mark.parametrize('band, worst', [('matched', 3e-3), ('raw', 1e-3)])
@pytest.mark.parametrize('t', STAMPS.values(), ids=STAMPS.keys())
def test_aligned_estimate_is_the_motion_at_its_instant(t, band, worst):
    now, motions = estimate(t, new(effort_band=band))
    np.testing.assert_allclose(delays(now, motions), VELOCITY_LAG + FILTER_DELAY, atol=2e-9)
    then = now - (VELOCITY_LAG + FILTER_DELAY)
    q, qd, qdd = trajectory(then)
    assert error(motions, 'q', q) < 1e-3
    assert error(motions, 'qd', qd) < 4e-3
    assert error(motions, 'qdd', qdd) < 5e-3
    assert error(motions, 'measured', effort(then)) < worst


def test_effort_is_filtered_like_velocity_of_the_same_instant(rng):
    """Velocity that lags by 20 ms is the same signal as effort."""
    signal = rng.normal(size=(300, 7)).cumsum(axis=0)
    velocity = signal[np.maximum(np.arange(300) - 2, 0)]  # lags by two samples
    motions = play(0.01 * np.arange(300), new(lag=0.02), None, velocity, signal)
    motions = [motion for motion in motions if motion]
    assert len(motions) > 250
    for motion in motions:
        np.testing.assert_allclose(motion.measured, motion.qd, rtol=0, atol=1e-9)


@pytest.mark.parametrize('missing', [(100, 101), (100, 140)])
def test_effort_is_withheld_until_its_filter_has_settled_again(missing):
    rows = [None if missing[0] <= k < missing[1] else row for k, row in enumerate(effort(T))]
    motions = play(T, new(), trajectory(T)[0], trajectory(T - VELOCITY_LAG)[1], rows)
    has_effort = np.array([motion is not None and motion.measured is not None
                           for motion in motions])
    assert has_effort[21:100].all()
    assert not has_effort[missing[0] + 2:missing[1] + 21].any()
    assert has_effort[missing[1] + 23:].all()
    assert all(motions[21:])  # predictions go on
    then = T[missing[1] + 23:] - (VELOCITY_LAG + FILTER_DELAY)
    assert error(motions[missing[1] + 23:], 'measured', effort(then)) < 3e-3


def test_unaligned_estimate_has_the_newest_values():
    estimator = new(align=False)
    assert estimator.delay == 0.0
    now, motions = estimate(T, estimator)
    assert np.abs(delays(now, motions)).max() < 2e-9
    for i in (0, 250, -1):
        np.testing.assert_array_equal(motions[i].q, trajectory(now)[0][i])
        np.testing.assert_array_equal(motions[i].qd, trajectory(now - VELOCITY_LAG)[1][i])
        np.testing.assert_array_equal(motions[i].measured, effort(now)[i])
    lagging = trajectory(now - VELOCITY_LAG - FILTER_DELAY)[2]
    assert error(motions, 'qdd', lagging) < 1e-2


@pytest.mark.parametrize('name, align', [('100 Hz', False), ('half a period of jitter', True)])
def test_estimates_are_withheld_until_settled(name, align):
    t, estimator = STAMPS[name], new(align=align)
    now, motions = estimate(t, estimator)
    assert estimator.settling_time == pytest.approx(SETTLED, rel=1e-12)
    np.testing.assert_array_equal(now, t[t - t[0] >= SETTLED])
    assert all(motion.measured is not None for motion in motions)
    estimator.reset()
    again, others = estimate(t, estimator)
    np.testing.assert_array_equal(again, now)
    for motion, other in zip(motions, others):
        np.testing.assert_array_equal(motion.measured, other.measured)


def test_estimates_are_withheld_until_history_reaches_back():
    estimator = new(lag=0.2, cutoff=50.0)
    now, _ = estimate(T, estimator)
    assert estimator.settling_time == estimator.delay > 0.2
    assert estimator.delay <= now[0] - T[0] < estimator.delay + 0.011


@pytest.mark.parametrize('name, lag', [('100 Hz', 0.015), ('400 Hz', 0.01625), ('50 Hz', 0.010)])
def test_missing_velocity_is_the_slope_of_the_positions(name, lag):
    now, motions = estimate(STAMPS[name], new(), measures_velocity=False)
    late_by = delays(now, motions)
    np.testing.assert_allclose(late_by, lag + FILTER_DELAY, atol=2e-9)
    late = now > now[0] + 0.8  # the slope begins at zero: a jump, which decays
    q, qd, qdd = trajectory((now - late_by)[late])
    motions = [motion for motion, is_late in zip(motions, late) if is_late]
    assert error(motions, 'q', q) < 1e-3
    assert error(motions, 'qd', qd) < 4e-3
    assert error(motions, 'qdd', qdd) < 5e-3
    assert error(motions, 'measured', effort((now - late_by)[late])) < 3e-3


@pytest.mark.parametrize('align', [True, False])
def test_repeated_stamp_gives_no_estimate(align):
    estimator = new(align=align)
    estimate(T, estimator)
    q, qd, _ = (array[0] for array in trajectory(T[-1:]))
    assert estimator.update(0, 0.0, q, qd, None).estimate is None
    assert estimator.update(0, 0.01, q, qd, None).estimate is not None


def test_velocity_is_aligned_with_position_and_raw_effort_of_its_instant():
    t = T - T[0]
    estimator = new()
    for row in zip(np.diff(t, prepend=0.0), trajectory(t)[0], trajectory(t - VELOCITY_LAG)[1],
                   effort(t)):
        found = estimator.update(10 ** 9, *row)
    assert found.stamp_ns == 986_000_000
    assert found.t == pytest.approx(t[-1] - VELOCITY_LAG, abs=1e-9)
    wanted = *trajectory(t[-1:] - VELOCITY_LAG)[:2], effort(t[-1:] - VELOCITY_LAG)
    for x, y in zip((found.q, found.qd, found.effort), wanted):
        np.testing.assert_allclose(x, y[0], atol=1e-2)

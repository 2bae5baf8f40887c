"""Evaluation of recordings: the node's own predictions, statistics, ranges for figures."""

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
from baxter_dynamics_ros.recordings.bands import INTERVALS, RunningBands
from baxter_dynamics_ros.recordings.playback import play
from baxter_dynamics_ros.recordings.running import RunningErrors
import numpy as np
import pytest

pytest.importorskip('pinocchio', reason='the comparison needs Pinocchio: pip install pin')
from baxter_dynamics_ros.newton_euler import NewtonEuler  # noqa: E402, I100
from baxter_dynamics_ros.recordings.evaluate_recordings import Evaluator  # noqa: E402

START = 10 ** 18  # [ns]
CALIBRATED = {'effort_model.coulomb': [0.3] * 7, 'effort_model.dahl': [0.2] * 7,
              'effort_model.bias': [0.1] * 7, 'effort_model.stiffness': [0.05] * 7,
              'effort_model.crosstalk': [0.0] * 49}


class Recording:
    """Joint states of a right arm that moves in sines, at 100 Hz."""

    name, topic, arm = 'sines', '/robot/joint_states', 'right'

    def __init__(self, n=1500, stamps=None, **changes):
        self.stamps = START + 10 ** 7 * np.arange(n) if stamps is None else stamps
        t = (self.stamps - START)[:, None] * 1e-9
        w = 2 * np.pi * np.array([0.3, 0.25, 0.35, 0.3, 0.4, 0.45, 0.5])
        center = np.array([0.0, -0.5, 0.0, 1.2, 0.0, 0.5, 0.0])
        self.q = center + 0.4 * np.sin(w * t + np.arange(7))
        self.qd = 0.4 * w * np.cos(w * (t - 0.014) + np.arange(7))
        qdd = -0.4 * w * w * np.sin(w * t + np.arange(7))
        model = PredictorSettings().model
        tau = model.arm.inverse_dynamics(self.q, 0.4 * w * np.cos(w * t + np.arange(7)), qdd)
        self.effort = model.effort_model.effort(tau, self.q, self.qd, qdd) + changes.get(
            'offset', 0.0) + np.random.default_rng(3).normal(0.0, 0.05, self.q.shape)
        self._without = changes.get('without', ())

    def __iter__(self):
        nothing = np.empty(0)
        for i, stamp in enumerate(self.stamps.tolist()):
            yield (stamp, joint_names('right'), self.q[i],
                   nothing if 'velocity' in self._without else self.qd[i],
                   nothing if 'effort' in self._without else self.effort[i], stamp + 1000)


def reference(values, recording):
    """Return predicted effort and residual as the node computes them one by one."""
    predictor = Predictor(PredictorSettings.from_parameters(values))
    predictions = [predictor.handle(*message[:5]).prediction for message in recording]
    return [p for p in predictions if p is not None]


@pytest.mark.parametrize('values', [CALIBRATED, {'align': False}], ids=['calibrated', 'unaligned'])
def test_statistics_are_those_of_the_nodes_predictions(values):
    recording = Recording()
    predictions = reference(values, recording)
    error = np.array([p.residual for p in predictions])
    effort = np.array([p.effort for p in predictions])
    evaluator = Evaluator(PredictorSettings.from_parameters(values))
    found = evaluator.evaluate(recording).methods['lagrange_euler']
    assert found.count == len(error)
    np.testing.assert_allclose(found.rms, np.sqrt((error ** 2).mean(0)), rtol=1e-9)
    np.testing.assert_allclose(found.mean_abs, np.abs(error).mean(0), rtol=1e-9)
    np.testing.assert_allclose(found.signed_mean, error.mean(0), atol=1e-9)
    for i in range(7):
        np.testing.assert_allclose(
            found.correlation[i], np.corrcoef(effort[:, i] + error[:, i], effort[:, i])[0, 1],
            rtol=1e-9)


def test_blocks_hold_the_nodes_predictions():
    predictor = Predictor(PredictorSettings.from_parameters(CALIBRATED))
    seen = [(block, predictor.predict(block.estimate)) for block in play(Recording(), predictor)]
    expected = reference(CALIBRATED, Recording())
    for field in ('stamp_ns', 'q', 'qd', 'qdd', 'tau', 'effort', 'residual'):
        np.testing.assert_allclose(
            np.concatenate([getattr(prediction, field) for _, prediction in seen]),
            [getattr(p, field) for p in expected], rtol=0, atol=1e-9, err_msg=field)


def test_estimators_differ_as_documented():
    recording = Recording()
    found = Evaluator(PredictorSettings()).evaluate(recording)
    np.testing.assert_array_equal(found.estimators['butterworth_aligned'].rms,
                                  found.methods['lagrange_euler'].rms)
    live = np.array([p.residual for p in reference({'align': False}, recording)])
    skipped = len(live) - found.estimators['butterworth_live'].count
    np.testing.assert_allclose(found.estimators['butterworth_live'].rms,
                               np.sqrt((live[skipped:] ** 2).mean(0)), rtol=1e-9)
    settings = PredictorSettings()
    qdd = np.diff(recording.qd, axis=0) / 0.01
    rows = slice(len(recording.q) - found.methods['lagrange_euler'].count, None)
    q, qd, effort = recording.q[rows], recording.qd[rows], recording.effort[rows]
    qdd = qdd[-len(q):]
    error = effort - settings.model.effort_model.effort(
        settings.model.arm.inverse_dynamics(q, qd, qdd), q, qd, qdd)
    np.testing.assert_allclose(found.estimators['first_difference'].rms,
                               np.sqrt((error ** 2).mean(0)), rtol=1e-6)


def test_terms_add_up():
    settings = PredictorSettings.from_parameters(CALIBRATED)
    found = Evaluator(PredictorSettings.from_parameters(CALIBRATED)).evaluate(Recording())
    blocks = [block.estimate for block in play(Recording(), Predictor(settings))]
    q, qd, qdd = (np.concatenate([getattr(e, f) for e in blocks]) for f in ('q', 'qd', 'qdd'))
    mass, coriolis, gravity = settings.model.arm.terms(q, qd)
    inertial = (mass @ qdd[..., None])[..., 0]
    np.testing.assert_allclose(found.shares['inertial'], np.sqrt((inertial ** 2).mean(0)))
    np.testing.assert_allclose(found.shares['gravity'], np.sqrt((gravity ** 2).mean(0)))
    np.testing.assert_allclose(found.shares['coriolis'], np.sqrt(
        ((coriolis @ qd[..., None])[..., 0] ** 2).mean(0)))
    np.testing.assert_allclose(found.shares['spring'][1], np.sqrt(
        (settings.model.effort_model.spring(q)[:, 1] ** 2).mean()))
    np.testing.assert_allclose(found.shares['other'], np.sqrt(
        ((0.1 + 0.05 * q) ** 2).mean(0)))
    assert (found.shares['friction'] > 0.1).all()


def test_terms_other_than_gravity_are_exactly_zero_at_rest():
    recording = Recording(200)
    recording.q[:], recording.qd[:] = recording.q[0], 0.0
    settings = PredictorSettings.from_parameters({'effort_model.crosstalk': [0.0] * 49})
    shares = Evaluator(settings).evaluate(recording).shares
    assert shares['gravity'][1] > 1.0 and shares['gravity'][0] == 0.0
    for term in ('inertial', 'coriolis', 'friction', 'other'):
        np.testing.assert_array_equal(shares[term], 0.0, err_msg=term)


@pytest.mark.parametrize('has_batches', [True, False], ids=['with OpenMP', 'without'])
def test_newton_euler_of_a_batch_equals_single_states(rng, monkeypatch, has_batches):
    if not has_batches:
        monkeypatch.delattr('pinocchio.rneaInParallel', raising=False)
    newton_euler = NewtonEuler(PredictorSettings.from_parameters({'payload.mass': 0.5}).model.arm)
    states = rng.normal(size=(3, 2, 20, 7))
    states[1, 0, 3] = np.nan
    found = newton_euler.inverse_dynamics(*states)
    expected = [[newton_euler.inverse_dynamics(*state) for state in zip(*rows)]
                for rows in zip(*states)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
    assert np.isnan(found).any(-1).sum() == 1  # an unknown velocity spoils no other state
    assert newton_euler.inverse_dynamics(*np.empty((3, 0, 7))).shape == (0, 7)


def test_recording_without_effort_has_predictions_only():
    found = Evaluator(PredictorSettings()).evaluate(Recording(without=('effort',)))
    assert found.methods == {} == found.estimators
    assert found.shares['gravity'][1] > 1.0
    assert np.isfinite(found.bands['lagrange_euler'].low).any()
    assert np.isnan(found.bands['measured'].low).all()
    assert any('effort_missing' in warning for warning in found.warnings)


def test_without_velocity_the_first_difference_is_left_out():
    found = Evaluator(PredictorSettings()).evaluate(Recording(without=('velocity',)))
    assert 'first_difference' not in found.estimators
    assert found.methods['lagrange_euler'].count > 1000
    assert any('velocity_missing' in warning for warning in found.warnings)


def test_stamps_that_are_times_of_arrival_are_a_warning():
    jitter = np.random.default_rng(0).uniform(0.0, 0.009, 1500)
    stamps = START + (1e9 * np.sort(0.01 * np.arange(1500) + jitter)).astype(int)
    found = Evaluator(PredictorSettings()).evaluate(Recording())
    assert not any('arrival' in w for w in found.warnings)
    found = Evaluator(PredictorSettings()).evaluate(Recording(stamps=stamps))
    assert any('times of arrival' in warning for warning in found.warnings)


def test_gaps_are_a_warning_and_stay_gaps():
    stamps = START + 10 ** 7 * np.concatenate([np.arange(700), np.arange(2000, 2700)])
    found = Evaluator(PredictorSettings()).evaluate(Recording(stamps=stamps))
    assert any('1 x reset_gap' in warning for warning in found.warnings)
    inside = (found.time > 8.0) & (found.time < 19.0)
    assert inside.any() and np.isnan(found.bands['measured'].low[inside]).all()
    assert found.duration == pytest.approx(2 * 7.0, abs=0.5)
    assert found.rate == pytest.approx(100.0, rel=1e-3)


def test_a_restart_of_the_filter_loses_no_message():
    recording = Recording()
    recording.qd = np.zeros_like(recording.qd)  # contradicts the positions: a restart
    kinds = {notice.kind for notice in Evaluator(PredictorSettings()).evaluate(recording).notices}
    assert 'velocity_mismatch' in kinds and 'lost' not in kinds
    recording = Recording(stamps=START + 10 ** 7 * np.delete(np.arange(1500), slice(700, 720)))
    kinds = {notice.kind for notice in Evaluator(PredictorSettings()).evaluate(recording).notices}
    assert 'lost' in kinds


def test_running_errors_do_not_cancel(rng):
    """Small errors on large efforts, in blocks of any size."""
    measured = 1e3 + rng.normal(0.0, 1e-3, (1000, 7))
    predicted = measured - 1e-3 - rng.normal(0.0, 1e-4, (1000, 7))
    errors = RunningErrors()
    for start, stop in ((0, 0), (0, 1), (1, 300), (300, 1000)):
        errors.add(measured[start:stop], predicted[start:stop])
    found, e = errors.result(), measured - predicted
    np.testing.assert_allclose(found.rms, np.sqrt((e ** 2).mean(0)), rtol=1e-6)
    np.testing.assert_allclose(found.signed_mean, e.mean(0), rtol=1e-6)
    np.testing.assert_allclose(
        found.correlation, [np.corrcoef(measured[:, i], predicted[:, i])[0, 1] for i in range(7)],
        rtol=1e-6)
    assert RunningErrors().result() is None


@pytest.mark.parametrize('n', [1, 999, 1000, 1001, 20000])
def test_bands_lose_no_peak(rng, n):
    time, signal = 0.01 * np.arange(n) + 0.003, rng.normal(size=(n, 2, 7))
    bands = RunningBands(['a', 'b'])
    for start in range(0, n, 300):
        bands.add(time[start:start + 300], signal[start:start + 300])
    middle, found = bands.result()
    assert len(middle) <= INTERVALS and found['a'].low.shape == (len(middle), 7)
    half = 0.5 * (middle[1] - middle[0]) if len(middle) > 1 else 0.005
    for i, t in enumerate(middle):
        inside = (time >= t - half - 1e-9) & (time < t + half - 1e-9)
        if inside.any():
            np.testing.assert_array_equal(found['b'].high[i], signal[inside, 1].max(0))
            np.testing.assert_array_equal(found['b'].low[i], signal[inside, 1].min(0))
        else:
            assert np.isnan(found['b'].high[i]).all()


def test_play_gives_blocks_of_bounded_size():
    sizes = [len(block.q) for block in play(Recording(), Predictor(PredictorSettings()))]
    assert max(sizes) <= 256 and sum(sizes) == 1500 - 21

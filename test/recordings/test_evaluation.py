"""Evaluation of recordings: the node's own predictions, statistics, ranges for figures."""

import tracemalloc
from typing import NamedTuple

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model import joint_names, rms
from baxter_dynamics_ros.recordings.evaluation_results import (INTERVALS, RunningBands,
                                                               RunningStatistics)
from baxter_dynamics_ros.recordings.playback import play, segments, stamp_statistics
import numpy as np
from perfect_robot import measured
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

    def __init__(self, n=600, stamps=None, without=()):
        self.stamps = START + 10 ** 7 * np.arange(n) if stamps is None else stamps
        self.q, self.qd, self.effort = measured(PredictorSettings(), 1e-9 * (self.stamps - START))
        self.effort += np.random.default_rng(3).normal(0.0, 0.05, self.q.shape)
        self._without = without

    def __iter__(self):
        nothing = np.empty(0)
        for i, stamp in enumerate(self.stamps.tolist()):
            yield (stamp, joint_names('right'), self.q[i],
                   nothing if 'velocity' in self._without else self.qd[i],
                   nothing if 'effort' in self._without else self.effort[i], stamp + 1000)


class Case(NamedTuple):
    """Settings, a recording, its evaluation, and the predictions of the node, one by one."""

    settings: PredictorSettings
    recording: Recording
    found: object
    predictions: list

    def rows(self, field):
        return np.array([getattr(prediction, field) for prediction in self.predictions])


@pytest.fixture(scope='module')
def case():
    """Return a function that returns the case of some values, each made once."""
    made = {}

    def case_(values):
        if str(values) not in made:
            settings, recording = PredictorSettings.from_parameters(values), Recording()
            predictor = Predictor(settings)
            steps = [predictor.handle(*message[:5]) for message in recording]
            made[str(values)] = Case(
                settings, recording, Evaluator(settings).evaluate(recording),
                [step.prediction for step in steps if step.prediction is not None])
        return made[str(values)]
    return case_


def evaluate(recording):
    return Evaluator(PredictorSettings()).evaluate(recording)


def kinds(recording):
    return {notice.kind for notice in evaluate(recording).notices}


@pytest.mark.parametrize('values', [CALIBRATED, {'align': False}], ids=['calibrated', 'unaligned'])
def test_statistics_are_those_of_the_nodes_predictions(case, values):
    found, error = case(values).found.methods['lagrange_euler'], case(values).rows('residual')
    effort = case(values).rows('effort')
    assert found.count == len(error)
    np.testing.assert_allclose(found.rms, rms(error), rtol=1e-9)
    np.testing.assert_allclose(found.mean_abs, np.abs(error).mean(0), rtol=1e-9)
    np.testing.assert_allclose(found.signed_mean, error.mean(0), atol=1e-9)
    for i in range(7):
        np.testing.assert_allclose(
            found.correlation[i], np.corrcoef(effort[:, i] + error[:, i], effort[:, i])[0, 1],
            rtol=1e-9)


def test_estimators_differ_as_documented(case):
    _, recording, found, predictions = case({})
    np.testing.assert_array_equal(found.estimators['butterworth_aligned'].rms,
                                  found.methods['lagrange_euler'].rms)
    live = case({'align': False}).rows('residual')
    skipped = len(live) - found.estimators['butterworth_live'].count
    np.testing.assert_allclose(found.estimators['butterworth_live'].rms, rms(live[skipped:]),
                               rtol=1e-9)
    model = PredictorSettings().model
    rows = slice(len(recording.q) - len(predictions), None)
    q, qd, effort = recording.q[rows], recording.qd[rows], recording.effort[rows]
    qdd = (np.diff(recording.qd, axis=0) / 0.01)[-len(q):]
    error = effort - model.effort_model.effort(model.arm.inverse_dynamics(q, qd, qdd), q, qd, qdd)
    np.testing.assert_allclose(found.estimators['first_difference'].rms, rms(error), rtol=1e-6)


def test_terms_add_up(case):
    found, model = case(CALIBRATED).found, case(CALIBRATED).settings.model
    q, qd, qdd = (case(CALIBRATED).rows(field) for field in ('q', 'qd', 'qdd'))
    mass, coriolis, gravity = model.arm.terms(q, qd)
    for term, values in {
            'inertial': (mass @ qdd[..., None])[..., 0], 'gravity': gravity,
            'coriolis': (coriolis @ qd[..., None])[..., 0],
            'other': 0.1 + 0.05 * q}.items():
        np.testing.assert_allclose(found.shares[term], rms(values), err_msg=term)
    np.testing.assert_allclose(found.shares['spring'], rms(model.effort_model.spring(q)))
    assert (found.shares['friction'] > 0.1).all()


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
    found = evaluate(Recording(without=('effort',)))
    assert found.methods == {} == found.estimators
    assert found.shares['gravity'][1] > 1.0
    assert np.isfinite(found.bands['lagrange_euler'].low).any()
    assert np.isnan(found.bands['measured'].low).all()
    assert 'effort_missing' in {notice.kind for notice in found.notices}


def test_residuals_before_effort_went_missing_do_not_explain_later_ones():
    recording = Recording(3300)
    recording.effort[1500:] = 0.0  # invalid
    first, *_, last = evaluate(recording).explained
    assert 'within the expected deviation' in first.text and 'too few' in last.text


def test_without_velocity_the_first_difference_is_left_out():
    found = evaluate(Recording(without=('velocity',)))
    assert 'first_difference' not in found.estimators
    assert found.methods['lagrange_euler'].count > 500
    assert 'velocity_missing' in {notice.kind for notice in found.notices}


def test_an_empty_recording_is_a_warning():
    assert '0 of 0 joint states are valid' in str(evaluate(Recording(0)).notices[0])


def test_stamps_that_are_times_of_arrival_are_a_warning(case):
    jitter = np.random.default_rng(0).uniform(0.0, 0.009, 600)
    stamps = START + (1e9 * np.sort(0.01 * np.arange(600) + jitter)).astype(int)
    assert 'stamps' in kinds(Recording(stamps=stamps))
    assert not case({}).found.notices


def test_gaps_are_a_warning_and_stay_gaps():
    found = evaluate(Recording(stamps=START + 10 ** 7 * np.r_[:300, 1600:1900]))
    assert any('1 x reset_gap' in str(notice) for notice in found.notices)
    inside = (found.time > 4.0) & (found.time < 15.0)
    assert inside.any() and np.isnan(found.bands['measured'].low[inside]).all()
    assert found.duration == pytest.approx(2 * 3.0, abs=0.5)
    assert found.rate == pytest.approx(100.0, rel=1e-3)


def test_a_restart_of_the_filter_loses_no_message():
    recording = Recording()
    recording.qd = np.zeros_like(recording.qd)  # contradicts the positions: a restart
    found = kinds(recording)
    assert 'velocity_mismatch' in found and 'lost' not in found
    assert 'lost' in kinds(Recording(
        stamps=START + 10 ** 7 * np.delete(np.arange(600), slice(300, 320))))


def test_sums_do_not_cancel(rng):
    """Small errors on large efforts, in blocks of any size."""
    measured = 1e3 + rng.normal(0.0, 1e-3, (1000, 7))
    predicted = measured - 1e-3 - rng.normal(0.0, 1e-4, (1000, 7))
    statistics = RunningStatistics()
    assert statistics.result().methods == {}
    for rows in (slice(0, 0), slice(0, 1), slice(1, 300), slice(300, 1000)):
        statistics.add('right', {'lagrange_euler': (measured[rows], predicted[rows])}, {},
                       np.zeros_like(measured[rows]))
    found, e = statistics.result().methods['lagrange_euler'], measured - predicted
    np.testing.assert_allclose(found.rms, rms(e), rtol=1e-6)
    np.testing.assert_allclose(found.signed_mean, e.mean(0), rtol=1e-6)
    np.testing.assert_allclose(found.correlation, [
        np.corrcoef(measured[:, i], predicted[:, i])[0, 1] for i in range(7)], rtol=1e-6)


def test_results_do_not_depend_on_the_size_of_a_block(monkeypatch):
    recording = Recording(2500)
    recording.effort[1000:1100, 2] += 9.0
    whole = evaluate(recording)
    monkeypatch.setattr('baxter_dynamics_ros.recordings.playback.BLOCK', 512)
    parts = evaluate(recording)
    assert parts.contacts == whole.contacts and parts.contacts[0].joint == 'e0'
    assert parts.notices == whole.notices and parts.duration == whole.duration
    np.testing.assert_array_equal(parts.time, whole.time)
    for name in whole.bands:
        np.testing.assert_array_equal(parts.bands[name], whole.bands[name])
    np.testing.assert_array_equal(parts.check.gain, whole.check.gain)
    assert parts.check.lag.value == pytest.approx(whole.check.lag.value, abs=5e-4)
    assert parts.check.velocity_scale == pytest.approx(whole.check.velocity_scale, abs=1e-3)


def test_memory_hardly_grows_with_a_recording(monkeypatch):
    """An interval (8 bytes), a quarter of residual and position, and copies of them at the end."""
    monkeypatch.setattr('baxter_dynamics_ros.recordings.playback.BLOCK', 256)
    monkeypatch.setattr('baxter_dynamics_ros.recordings.data_check._ROWS', 100)

    def peak(n):
        recording = Recording(n)
        tracemalloc.start()
        evaluate(recording)
        found = tracemalloc.get_traced_memory()[1]  # [bytes]
        tracemalloc.stop()
        return found

    evaluate(Recording(300))  # makes what is made once
    assert peak(2000) - peak(1200) < 100 * 800


@pytest.mark.parametrize('n', [0, 1, 1000, 1001, 5000])
def test_bands_lose_no_peak(rng, n):
    time, signal = 0.01 * np.arange(n) + 0.003, rng.normal(size=(n, 7))
    bands = RunningBands('a')
    for rows in (slice(i, i + 170) for i in range(0, n, 170)):
        bands.add(time[rows], signal[rows, None])
    middle, found = bands.result()
    assert len(middle) <= INTERVALS and found['a'].low.shape == (len(middle), 7)
    half = 0.5 * (middle[1] - middle[0]) if len(middle) > 1 else 0.005
    for i, t in enumerate(middle):
        inside = (time >= t - half - 1e-9) & (time < t + half - 1e-9)
        np.testing.assert_array_equal(found['a'].high[i], signal[inside].max(0))
        np.testing.assert_array_equal(found['a'].low[i], signal[inside].min(0))


@pytest.mark.parametrize('lose, lost', [
    (lambda t, rng: t, 0),
    (lambda t, rng: np.delete(t, slice(500, 517)), 17),  # a gap of 180 ms
    (lambda t, rng: np.delete(t, rng.choice(np.arange(1, 2199), 600, replace=False)), 600),
    (lambda t, rng: np.delete(t, np.arange(1, 2199, 2)), 0),  # every other: half the rate
    (lambda t, rng: np.delete(t, slice(500, 600)), 0),  # a pause
], ids=['none', 'one gap', 'a quarter', 'every other', 'pause'])
def test_robots_stamps_lie_on_a_grid(rng, lose, lost):
    times = lose(0.01 * np.arange(2200), rng)
    found = stamp_statistics(np.diff(times + 4e-5 * rng.normal(size=len(times))))
    assert found.irregularity < 0.02
    assert abs(found.lost - lost) <= 0.02 * lost
    assert found.duration == pytest.approx(22.0, abs=1.1)


def test_times_of_arrival_lie_on_no_grid(rng):
    bursts = np.sort(0.01 * np.arange(2200) + rng.exponential(0.0138, 2200))
    assert stamp_statistics(np.diff(bursts)).irregularity > 0.2
    jitter = 0.01 * np.arange(2200) + rng.normal(0.0, 0.002, 2200)
    assert stamp_statistics(np.diff(jitter)).irregularity > 0.15
    assert stamp_statistics(np.array([0.3, 0.01])) == (0.01, 100.0, 0.0, 0.0, 0)  # too few


def test_stamps_that_step_back_count_as_a_gap():
    stamps = np.tile(START + 10 ** 7 * np.arange(100), 2)
    (samples,) = play(Recording(stamps=stamps), Predictor(PredictorSettings()))
    assert len(segments(samples.time)) == 2 and (np.diff(samples.time) > 0.0).all()

"""Pushes put on recordings of real arms are found, soon, and next to nothing else is."""

from functools import lru_cache
from pathlib import Path
import sys

from baxter_dynamics_ros.model.effort import EffortModel
import numpy as np
import pytest

pytest.importorskip('mujoco', reason='the benchmark needs MuJoCo: pip install ".[demo]"')
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / 'benchmarks'))
import contact as benchmark  # noqa: E402, I100
sys.path.pop(0)

TRACKING, REACHING = 'baxter_left_arm_tracking.npz', 'baxter_point_to_point.npz'


@lru_cache
def load(folder):
    """Return recordings: a third of the tracking ones, the reaching, and a third to fit to."""
    files = benchmark.recordings(folder)
    return {TRACKING: files[TRACKING][::3], REACHING: files[REACHING]}, files[TRACKING][2::3]


@lru_cache
def judged(folder, file, calibrated=False):
    """Return latencies at the hand and the elbow [ms], false contacts, and minutes."""
    motions, fitted = load(folder)
    model = benchmark.calibrated(fitted) if calibrated else EffortModel()
    hand, elbow, false, minutes = [], [], 0, 0.0
    for motion in motions[file]:
        plan = benchmark.pushes(benchmark.times(motion)[-1], benchmark.ELBOW['recording'])
        found = benchmark.contacts(benchmark.pushed(motion, plan), model)
        late = 1e3 * benchmark.latencies(motion, found, plan)
        at_elbow = np.array([push.torque.any() for push in plan])
        hand, elbow = [*hand, *late[~at_elbow]], [*elbow, *late[at_elbow]]
        false += benchmark.begun(benchmark.contacts(motion, model))
        minutes += len(found) * motion.period / 60.0
    print(file, *(np.percentile(x, [50, 90, 100]).round() for x in (hand, elbow)), false, minutes)
    return np.array(hand), np.array(elbow), false, minutes


@pytest.mark.parametrize('file', [TRACKING, REACHING])
def test_every_push_is_found_and_soon(recordings, file):
    hand, elbow, _, _ = judged(recordings, file)
    assert len(hand) > 40 and len(elbow) > 12
    assert np.isfinite(hand).all() and np.percentile(hand, 90) <= 120.0
    assert np.isfinite(elbow).all() and np.percentile(elbow, 90) <= 220.0


@pytest.mark.parametrize('file', [TRACKING, REACHING])
def test_at_most_two_false_contacts_a_minute(recordings, file):
    _, _, false, minutes = judged(recordings, file)
    assert false <= 2.0 * minutes


def test_calibrated_on_other_recordings_it_is_better(recordings):
    hand, elbow, false, minutes = judged(recordings, TRACKING, calibrated=True)
    before, _, _, _ = judged(recordings, TRACKING)
    assert np.isfinite(hand).all() and np.percentile(hand, 90) <= 100.0
    assert np.percentile(hand, 90) < np.percentile(before, 90)
    assert np.isfinite(elbow).all() and np.percentile(elbow, 90) <= 220.0
    motions = benchmark.recordings(recordings)[TRACKING][1::3]
    model = benchmark.calibrated(load(recordings)[1])
    false += sum(benchmark.begun(benchmark.contacts(motion, model)) for motion in motions)
    assert false <= 0.5 * 2.0 * minutes


def test_external_torque_has_a_fraction_of_the_first_differences_noise(recordings):
    motions, _ = load(recordings)
    for motion in sum(motions.values(), []):
        period, model = motion.period, EffortModel()
        external = benchmark.external_torque(motion, model)[round(1.0 / period):]
        ratio = (benchmark.rms(benchmark.without_mean(external, period))
                 / benchmark.rms(benchmark.without_mean(
                     benchmark.first_difference(motion, model), period)))
        print(motion.name, round(ratio, 3))
        assert ratio <= 0.13


def test_predictors_residual_has_a_fraction_of_it_too(recordings):
    for motion in sum(load(recordings)[0].values(), []):
        motion = motion._replace(**{name: getattr(motion, name)[:2500]
                                    for name in ('q', 'qd', 'effort')})
        period = motion.period
        ratio = (benchmark.rms(benchmark.without_mean(benchmark.residual(motion), period))
                 / benchmark.rms(benchmark.without_mean(
                     benchmark.first_difference(motion, EffortModel()), period)))
        print(motion.name, round(ratio, 3))
        assert ratio <= 0.20

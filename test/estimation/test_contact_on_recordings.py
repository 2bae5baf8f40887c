"""Pushes added to recordings of real arms are found soon, with few false contacts."""

from functools import lru_cache
from pathlib import Path
import sys

import numpy as np
import pytest

pytest.importorskip('mujoco', reason='the benchmark needs MuJoCo: pip install ".[demo]"')
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / 'benchmarks'))
import contact as benchmark  # noqa: E402, I100
sys.path.pop(0)

TRACKING, REACHING = 'baxter_left_arm_tracking.npz', 'baxter_point_to_point.npz'


@lru_cache
def load(folder):
    """Return recordings: a third of the tracking ones, the reaching, and the fit to others."""
    files = benchmark.recordings(folder)
    return ({TRACKING: files[TRACKING][::3], REACHING: files[REACHING]},
            benchmark.calibrated(files[TRACKING][2::3]))


@lru_cache
def judged(folder, file, calibrated=False):
    """Return latencies at the hand and the elbow [ms], false contacts, and minutes."""
    motions, fitted = load(folder)
    values = fitted if calibrated else {}
    hand, elbow, false, minutes = [], [], 0, 0.0
    for motion in motions[file]:
        plan = benchmark.plan_for(motion)
        found = benchmark.play(benchmark.pushed(motion, plan), values).contact
        late = 1e3 * benchmark.latencies(motion, found, plan)
        at_elbow = np.array([push.torque.any() for push in plan])
        hand, elbow = [*hand, *late[~at_elbow]], [*elbow, *late[at_elbow]]
        free = benchmark.play(motion, values).contact
        if file == REACHING:  # e0 presses on its stop
            free[(motion.times > 123.0) & (motion.times < 125.5)] = False
        false += benchmark.begun(free)
        minutes += motion.times[-1] / 60.0
    print(file, *(np.percentile(x, [50, 90]).round() for x in (hand, elbow)), false, minutes)
    return np.array(hand), np.array(elbow), false, minutes


@pytest.mark.parametrize('file', [TRACKING, REACHING])
def test_pushes_are_found_soon(recordings, file):
    hand, elbow, _, _ = judged(recordings, file)
    assert len(hand) > 40 and len(elbow) > 12
    # A push that begins during a false contact does not count as found.
    assert np.isinf(hand).sum() <= 1 and np.percentile(hand, 90) <= 120.0
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
    _, values = load(recordings)
    false += sum(benchmark.begun(benchmark.play(motion, values).contact) for motion in motions)
    assert false <= 0.5 * 2.0 * minutes


def test_residual_and_external_torque_have_a_fraction_of_the_first_differences_noise(recordings):
    for motion in sum(load(recordings)[0].values(), []):
        residual, external = benchmark.noise(motion, window=1.0)
        print(motion.name, round(residual, 3), round(external, 3))
        assert residual <= 0.20 and external <= 0.13

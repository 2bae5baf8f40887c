"""Delay and false alarms of contact detection, on the fake Baxter and on recordings."""

from functools import lru_cache
from pathlib import Path
import sys

import numpy as np
import pytest

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / 'benchmarks'))
import contact as benchmark  # noqa: E402, I100
sys.path.pop(0)

SEED = 3
FORCES = (10.0, 200.0)  # [N]; the benchmark has more, and longer runs
PLAN = benchmark.pushes(8 * len(FORCES), benchmark.ELBOW['fake'], FORCES)
AT_ELBOW = np.array([push.torque.any() for push in PLAN])
MODELS = {'uncalibrated': {}, 'friction_known': benchmark.FRICTION}
TRACKING, REACHING = 'baxter_left_arm_tracking.npz', 'baxter_point_to_point.npz'

CASES = pytest.mark.parametrize('trajectory, rate, model', [
    ('hold', 200, 'uncalibrated'), ('switch', 50, 'uncalibrated'),
    ('switch', 100, 'friction_known')])


@lru_cache
def run(trajectory, pushed=True):
    """Return the motion of a robot pushed according to PLAN, or 12 s without pushes."""
    if pushed:
        return benchmark.run(trajectory, SEED, PLAN[-1].begin + benchmark.SPACING, PLAN)
    return benchmark.run(trajectory, SEED, 12.0)


@lru_cache
def judged(trajectory, rate, model, pushed=True):
    """Return the motion, and whether there is contact at each sample (n,)."""
    motion = benchmark.at_rate(run(trajectory, pushed), rate)
    return motion, benchmark.play(motion, MODELS[model]).contact


@CASES
def test_every_push_is_found_soon_and_until_it_ends(trajectory, rate, model):
    motion, contact = judged(trajectory, rate, model)
    late = 1e3 * benchmark.latencies(motion, contact, PLAN)
    hand, elbow = late[~AT_ELBOW], late[AT_ELBOW]
    print(*(np.percentile(x, [50, 90, 100]).round() for x in (hand, elbow)))
    assert np.isfinite(late).all()
    assert np.percentile(hand, 90) <= 60.0 and np.percentile(elbow, 90) <= 120.0
    assert (benchmark.shares(motion, contact, PLAN) >= 0.99).all()
    for push in PLAN:
        after = motion.times - push.begin - benchmark.LENGTH
        # The arm swings back from a hard push.
        swings = 0.6 if np.abs(push.force).max() <= 10.0 else 0.85  # [s]
        assert not contact[(after > swings) & (after < 1.5)].any()


@CASES
def test_no_contact_without_a_push(trajectory, rate, model):
    assert not judged(trajectory, rate, model, pushed=False)[1].any()
    motion, contact = judged(trajectory, rate, model)
    begin = motion.times[1:][contact[1:] & ~contact[:-1]]
    since = begin[:, None] - np.array([push.begin for push in PLAN])
    assert ((since > 0.0) & (since < benchmark.LENGTH + 0.5)).any(axis=1).all()


def test_contact_lasts_as_long_as_a_push_of_ten_newtons():
    push = benchmark.Push(4.0, np.array([10.0, 0.0, 0.0]), np.zeros(7))
    motion = benchmark.at_rate(benchmark.run('hold', SEED, 11.0, [push], length=6.0), 100)
    t, contact = motion.times, benchmark.play(motion, benchmark.FRICTION).contact
    assert not contact[t < 4.0].any()
    assert contact[(t > 4.1) & (t < 10.0)].all()
    assert not contact[t > 10.6].any()


@pytest.mark.parametrize('trajectory, limit', [('hold', 0.10), ('switch', 0.13)])
def test_residual_has_a_fraction_of_the_noise_of_the_first_difference(trajectory, limit):
    ratios = benchmark.noise(benchmark.at_rate(run(trajectory, False), 100), benchmark.FRICTION)
    print(trajectory, ratios)
    assert max(ratios) <= limit


# ---- recordings of real arms

@lru_cache
def load(folder):
    """Return a part of the recordings by file; the benchmark has all."""
    files = benchmark.recordings(folder)
    (reaching,) = files[REACHING]
    return {TRACKING: files[TRACKING][::6], REACHING: [reaching.part(slice(0, 8000))],
            'another': files[TRACKING][2:3]}


@lru_cache
def judged_on(folder, file, calibrated=False):
    """Return latencies at the hand and the elbow [ms], false contacts, and minutes."""
    motions = load(folder)
    values = benchmark.calibrated(motions['another']) if calibrated else {}
    hand, elbow, false, minutes = [], [], 0, 0.0
    for motion in motions[file]:
        plan = benchmark.plan_for(motion)
        found = benchmark.play(benchmark.pushed(motion, plan), values).contact
        late = 1e3 * benchmark.latencies(motion, found, plan)
        at_elbow = np.array([push.torque.any() for push in plan])
        hand, elbow = [*hand, *late[~at_elbow]], [*elbow, *late[at_elbow]]
        false += benchmark.begun(benchmark.play(motion, values).contact)
        minutes += motion.times[-1] / 60.0
    print(file, *(np.percentile(x, [50, 90]).round() for x in (hand, elbow)), false, minutes)
    return np.array(hand), np.array(elbow), false, minutes


@pytest.mark.parametrize('file', [TRACKING, REACHING])
def test_pushes_are_found_soon_with_at_most_two_false_contacts_a_minute(recordings, file):
    hand, elbow, false, minutes = judged_on(recordings, file)
    assert len(hand) >= 18 and len(elbow) >= 5
    # A push that begins during a false contact does not count as found.
    assert np.isinf(hand).sum() <= 1 and np.percentile(hand, 90) <= 120.0
    assert np.isfinite(elbow).all() and np.percentile(elbow, 90) <= 220.0
    assert false <= 2.0 * minutes


def test_calibration_on_another_recording_improves_detection(recordings):
    hand, elbow, false, minutes = judged_on(recordings, TRACKING, calibrated=True)
    before, *_ = judged_on(recordings, TRACKING)
    assert np.isfinite(hand).all() and np.percentile(hand, 90) <= 100.0
    assert np.percentile(hand, 90) < np.percentile(before, 90)
    assert np.isfinite(elbow).all() and np.percentile(elbow, 90) <= 220.0
    assert false <= 0.5 * 2.0 * minutes


def test_noise_of_residual_and_external_torque_on_recordings(recordings):
    for file in (TRACKING, REACHING):
        motion = load(recordings)[file][0].part(slice(0, 3000))
        residual, external = benchmark.noise(motion, window=1.0)
        print(motion.name, round(residual, 3), round(external, 3))
        assert residual <= 0.20 and external <= 0.13

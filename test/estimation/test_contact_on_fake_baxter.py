"""Pushes on the fake Baxter are found, soon, and next to nothing else is; at 50 and 100 Hz."""

from functools import lru_cache
from pathlib import Path
import sys

from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / 'benchmarks'))
import contact as benchmark  # noqa: E402, I100
sys.path.pop(0)

DURATION = 38.0  # of a run with pushes [s]; the benchmark's are longer, and of more seeds
QUIET = 12.0  # of one without [s]
SEED = 3
PLAN = benchmark.pushes(DURATION, benchmark.ELBOW['fake'])
AT_ELBOW = np.array([push.torque.any() for push in PLAN])
MODELS = {'uncalibrated': EffortModel(), 'friction_told': benchmark.TOLD}

TRAJECTORIES = pytest.mark.parametrize('trajectory', benchmark.TRAJECTORIES)
RATES = pytest.mark.parametrize('rate', [50, 100])


@lru_cache
def run(trajectory, rate, pushed=True):
    """Return what the robot publishes, pushed as planned or not at all."""
    if rate == 50:
        return benchmark.every_second(run(trajectory, 100, pushed))
    if pushed:
        return benchmark.run(trajectory, SEED, DURATION, PLAN)
    return benchmark.run(trajectory, SEED, QUIET)


@lru_cache
def judged(trajectory, rate, model, pushed=True):
    """Return what the robot publishes, and whether each sample finds contact (n,)."""
    motion = run(trajectory, rate, pushed)
    return motion, benchmark.contacts(motion, MODELS[model])


def found_after(rate, model):
    """Return after how long pushes at the hand, and at the elbow, are found [ms]."""
    late = 1e3 * np.array([benchmark.latencies(*judged(trajectory, rate, model), PLAN)
                           for trajectory in benchmark.TRAJECTORIES])
    hand, elbow = late[:, ~AT_ELBOW], late[:, AT_ELBOW]
    print(rate, model, *(np.percentile(x, [50, 90, 100]).round() for x in (hand, elbow)))
    return hand, elbow


@RATES
def test_every_push_is_found_and_soon(rate):
    hand, elbow = found_after(rate, 'friction_told')
    assert hand.size >= 30 and elbow.size >= 6
    assert np.isfinite(hand).all() and np.percentile(hand, 90) <= 60.0
    assert np.isfinite(elbow).all() and np.percentile(elbow, 90) <= 120.0


@RATES
def test_every_push_is_found_without_being_told_the_friction(rate):
    hand, elbow = found_after(rate, 'uncalibrated')
    assert np.isfinite(hand).all() and np.percentile(hand, 90) <= 65.0
    assert np.isfinite(elbow).all() and np.percentile(elbow, 90) <= 120.0


@TRAJECTORIES
@RATES
@pytest.mark.parametrize('model', MODELS)
def test_nothing_else_is(trajectory, rate, model):
    assert not judged(trajectory, rate, model, pushed=False)[1].any()
    motion, found = judged(trajectory, rate, model)
    begin = benchmark.times(motion)[1:][found[1:] & ~found[:-1]]
    since = begin[:, None] - np.array([push.begin for push in PLAN])
    assert ((since > 0.0) & (since < benchmark.LENGTH + 0.5)).any(axis=1).all()


@TRAJECTORIES
def test_contact_ends_with_the_push(trajectory):
    motion, found = judged(trajectory, 100, 'friction_told')
    t = benchmark.times(motion)
    for push in PLAN:
        during = (t > push.begin + 0.25) & (t < push.begin + benchmark.LENGTH)
        after = (t > push.begin + benchmark.LENGTH + 0.6) & (t < push.begin + 2.3)
        assert found[during].mean() > 0.9
        assert not found[after].any()


def test_ten_newtons_stay_contact_for_as_long_as_they_last():
    push = benchmark.Push(4.0, np.array([10.0, 0.0, 0.0]), np.zeros(7))
    motion = benchmark.run('hold', SEED, 11.0, [push], length=6.0)
    t, found = benchmark.times(motion), benchmark.contacts(motion, benchmark.TOLD)
    assert not found[t < 4.0].any()
    assert found[(t > 4.1) & (t < 10.0)].all()
    assert not found[t > 10.6].any()


@TRAJECTORIES
def test_residuals_have_a_fraction_of_the_first_differences_noise(trajectory):
    limit = 0.13 if trajectory == 'switch' else 0.10
    motion, settled = run(trajectory, 100, False), 100
    difference = benchmark.rms(benchmark.first_difference(motion, benchmark.TOLD))
    external = benchmark.rms(benchmark.external_torque(motion, benchmark.TOLD)[settled:])
    told = {'effort_model.coulomb': benchmark.COULOMB}
    predictor = benchmark.rms(benchmark.residual(motion, **told))
    print(trajectory, predictor / difference, external / difference)
    assert external <= limit * difference
    assert predictor <= limit * difference


def test_the_stream_handler_finds_the_same():
    motion = run('switch', 100)
    names, predictor = joint_names('right'), PredictorSettings().predictor(external=True)
    contact = []
    for k, row in enumerate(zip(motion.q[:1600], motion.qd, motion.effort)):
        predictor.handle(10 ** 18 + k * 10_000_000, names, *row)
        contact.append(bool(predictor.external.latest and predictor.external.latest.contact))
    np.testing.assert_array_equal(contact, judged('switch', 100, 'uncalibrated')[1][:1600])
    assert any(contact)

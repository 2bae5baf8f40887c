"""Measured velocity against positions: zero, frozen, other units, and real recordings."""

from baxter_dynamics_ros.estimation.continuity import VelocityCheck
from baxter_dynamics_ros.estimation.events import Event
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
from perfect_robot import measured
import pytest

RIGHT = joint_names('right')
START = 10 ** 18  # [ns]
PERIOD = 0.01  # [s]
T = np.arange(0.0, 10.0, PERIOD)
WRONG = {'zero': lambda qd: 0.0 * qd, 'frozen': lambda qd: 0.0 * qd + 0.3,
         'rpm': lambda qd: qd * 30 / np.pi}


def play(spoil, until=len(T)):
    """Play a perfect robot, with velocity spoilt in the first messages."""
    predictor = Predictor(PredictorSettings(), external=True)
    made = []
    for k, (q, qd, effort) in enumerate(zip(*measured(PredictorSettings(), T))):
        made.append(predictor.handle(START + k * 10_000_000, RIGHT, q,
                                     spoil(qd) if k < until else qd, effort))
    return predictor, made


@pytest.mark.parametrize('spoil', WRONG.values(), ids=WRONG.keys())
def test_slope_of_positions_replaces_wrong_velocity(spoil):
    predictor, made = play(spoil)
    counts = predictor.counts
    assert counts[Event.VELOCITY_MISMATCH] > len(T) - 150
    assert counts[Event.RESET_VELOCITY_SOURCE] == 1
    mismatch = predictor.stream.velocity_check.mismatch
    assert abs(mismatch.moved - mismatch.integrated) > 0.05
    assert np.abs([step.prediction.residual for step in made[300:]]).max() < 0.5
    assert not any(step.external.contact for step in made[300:])


def test_measured_velocity_is_used_again_when_it_agrees():
    predictor, made = play(WRONG['zero'], until=400)
    assert predictor.counts[Event.RESET_VELOCITY_SOURCE] == 2
    assert predictor.stream.velocity_check.mismatch is None
    assert made[-1].state.qd is not None and made[-1].delay == pytest.approx(0.059, abs=1e-3)


def test_frozen_positions_are_reported():
    predictor = Predictor(PredictorSettings())
    for k in range(200):
        predictor.handle(START + k * 10_000_000, RIGHT, np.zeros(7), np.full(7, 0.3),
                         np.full(7, 1.0 + 0.01 * (k % 3)))
    assert predictor.counts[Event.POSITION_FROZEN] > 100
    assert predictor.counts[Event.VELOCITY_MISMATCH] == 0


def test_velocity_that_lags_a_fast_small_motion_agrees():
    check, t = VelocityCheck(), np.arange(0.0, 3.0, 0.0025)
    w = 60.0  # [rad/s]; a joint that a push of 200 N throws to and fro
    assert all(check.update(0.0025, np.full(7, q), np.full(7, qd)) for q, qd in zip(
        0.15 * np.sin(w * t), 0.15 * w * np.cos(w * (t - 0.014))))


@pytest.mark.parametrize('name', ['left_arm_tracking', 'point_to_point'])
def test_real_velocity_agrees(recordings, name):
    data = {key: value[:5000] if value.ndim else value
            for key, value in np.load(recordings / f'baxter_{name}.npz').items()}
    check, last = VelocityCheck(), None
    for q, qd, recording in zip(data['position'], data['velocity'], data['recording']):
        if recording != last:
            check.restart()
        last = recording
        assert check.update(float(data['period']), q, qd)

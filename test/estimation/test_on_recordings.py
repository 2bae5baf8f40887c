"""Predictor on recordings of a real arm: residual, and the effect of each step on it."""

from functools import lru_cache
from pathlib import Path

from arrivals import bursts
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.retiming import Retiming
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model import BaxterArm, EffortModel, joint_names, S1
import numpy as np
import pytest

SETTLING = 21  # samples: the first and those within 0.207 s of it


@pytest.fixture
def tracking(recordings):
    """Return the period [s] and a list of (position, velocity, effort), each (n, 7)."""
    return load(recordings)


@lru_cache
def load(folder: Path) -> tuple:
    with np.load(folder / 'baxter_left_arm_tracking.npz') as file:
        assert tuple(file['joint_names']) == joint_names('left')
        which = file['recording']
        fields = [file[name] for name in ('position', 'velocity', 'effort')]
        period = float(file['period'])
    recordings = [tuple(field[which == i] for field in fields) for i in range(which.max() + 1)]
    assert len(recordings) == 12
    return period, recordings


def residuals(period: float, recordings: list, **values) -> list:
    """Play each recording to a new predictor; return the residual of each, (n, 7) [N m]."""
    names, result = joint_names('left'), []
    settings = PredictorSettings.from_parameters({'arm': 'left'} | values)
    for recording in recordings:
        predictor = Predictor(settings)
        predictions = [predictor.handle(round(i * period * 1e9), names, *arrays).prediction
                       for i, arrays in enumerate(zip(*recording))]
        result.append(np.array([p.residual for p in predictions if p is not None]))
        n = len(predictions)
        assert predictor.counts == {'received': n, 'taken': n, 'predicted': n - SETTLING}
    return result


@lru_cache
def pipeline_residuals(folder: Path) -> list:
    period, all_ = load(folder)
    return residuals(period, all_[::4])


def rms(parts: list) -> np.ndarray:
    """Return the RMS (7,) of a list of arrays (n, 7)."""
    return np.sqrt(np.nanmean(np.concatenate(parts) ** 2, axis=0))


def test_residual_of_the_pipeline(recordings):
    limit = [0.95, 0.96, 0.85, 0.60, 0.15, 0.34, 0.21]  # [N m]
    left = rms(pipeline_residuals(recordings))
    print('residual RMS [N m]:', left.round(2))
    assert (left < limit).all()


def test_alignment_lowers_the_residual(recordings, tracking):
    period, all_ = tracking
    aligned = rms(pipeline_residuals(recordings))
    unaligned = rms(residuals(period, all_[::4], align=False))
    assert (aligned < unaligned)[:6].all()
    assert aligned[6] < 1.01 * unaligned[6]  # w2 hardly moves


def test_first_order_difference_is_worse(recordings, tracking):
    """As the paper computes it: newest values, acceleration from the last two velocities."""
    period, all_ = tracking
    arm, model, prototype = BaxterArm(), EffortModel(), []
    for q, qd, effort in all_:
        q, qd, qdd, effort = q[1:], qd[1:], np.diff(qd, axis=0) / period, effort[1:]
        prototype.append(effort - model.effort(arm.inverse_dynamics(q, qd, qdd), q, qd, qdd))
    print("with the paper's first difference:", rms(prototype).round(2))
    np.testing.assert_allclose(
        rms(prototype), [4.39, 3.17, 2.50, 1.45, 0.23, 0.37, 0.20], atol=0.05)
    assert (rms(pipeline_residuals(recordings)) < rms(prototype[::4]))[:6].all()


def test_without_the_spring_s1_cannot_be_predicted(tracking):
    period, all_ = tracking
    part = [field[:2000] for field in all_[0]]
    without = residuals(period, [part], **{'effort_model.enabled': False})
    assert rms(without)[S1] > 15.0


def test_re_timed_bursts_equal_even_stamps(tracking):
    period, all_ = tracking
    samples = [field[:2000] for field in all_[2]]
    t = 0.3 + np.arange(2000) * period
    retiming = Retiming('auto')
    arrivals = [round(x * 1e9) for x in bursts(t)]
    retimed = [retiming.update(stamp, True) for stamp in arrivals]
    assert retiming.retimed
    settings, found = PredictorSettings(arm='left', stamps='header'), []
    for stamps in ([round(x * 1e9) for x in t], retimed, arrivals):
        predictor = Predictor(settings)
        predictions = [predictor.handle(stamp, joint_names('left'), *sample).prediction
                       for stamp, *sample in zip(stamps, *samples) if stamp is not None]
        found.append([(p.qdd, p.residual) if p else np.full((2, 7), np.nan)
                      for p in predictions[-1500:]])
    (qdd, residual), (retimed_qdd, retimed_residual), (_, arrival_residual) = (
        np.array(each).swapaxes(0, 1) for each in found)
    ratio = rms([retimed_residual]) / rms([residual])
    wrong = rms([retimed_qdd - qdd]) / rms([qdd])
    print('residual times', ratio.round(3), 'acceleration differs by', wrong.round(4))
    assert np.abs(ratio - 1).max() < 0.05 and wrong.max() < 0.05
    assert (rms([arrival_residual]) / rms([residual])).max() > 1.2

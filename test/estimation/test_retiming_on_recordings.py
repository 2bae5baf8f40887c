"""Recordings of a real arm whose messages come in bursts, re-timed: as good as even stamps."""

from arrivals import bursts, Retiming
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest

SETTLED = 400  # messages


@pytest.fixture(params=[2, 9])
def recording(recordings, request):
    """Return the period [s], and position, velocity and effort, each (n, 7), of a recording."""
    with np.load(recordings / 'baxter_left_arm_tracking.npz') as file:
        rows = np.flatnonzero(file['recording'] == request.param)[:3000]
        return float(file['period']), [file[name][rows]
                                       for name in ('position', 'velocity', 'effort')]


def play(stamps, samples):
    """Return the accelerations and residuals (n, 7) of each message, NaN where there are none."""
    names = joint_names('left')
    predictor = Predictor(PredictorSettings.from_parameters({'arm': 'left', 'stamps': 'header'}))
    result = np.full((2, *samples[0].shape), np.nan)
    for i, (stamp, *sample) in enumerate(zip(stamps, *samples)):
        if stamp is not None:
            prediction = predictor.handle(stamp, names, *sample).prediction
            if prediction is not None:
                result[:, i] = prediction.qdd, prediction.residual
    return result


def rms(x):
    """Return the RMS per joint (7,) of what is there."""
    return np.sqrt(np.nanmean(x[SETTLED:] ** 2, axis=0))


def test_re_timed_bursts_are_as_good_as_even_stamps(recording):
    period, samples = recording
    t = 0.3 + np.arange(len(samples[0])) * period
    retiming = Retiming('auto')
    arrivals = [round(x * 1e9) for x in bursts(t)]
    retimed = [retiming.update(stamp, True) for stamp in arrivals]
    assert retiming.retimed and retiming.resyncs == 0
    qdd, residual = play([round(x * 1e9) for x in t], samples)
    retimed_qdd, retimed_residual = play(retimed, samples)
    _, arrival_residual = play(arrivals, samples)
    ratio = rms(retimed_residual) / rms(residual)
    wrong = rms(retimed_qdd - qdd)
    print('acceleration [rad/s^2], RMS', rms(qdd).round(3), 'differs by', wrong.round(4))
    print('residual', rms(residual).round(3), 'times', ratio.round(3), 'with arrivals times',
          (rms(arrival_residual) / rms(residual)).round(2))
    assert np.abs(ratio - 1).max() < 0.05
    assert (wrong < 0.05 * rms(qdd)).all()
    assert (rms(arrival_residual) / rms(residual)).max() > 1.2

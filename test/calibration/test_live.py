"""Calibration in a process of its own, and the progress shown before it."""

import os
import subprocess

from baxter_dynamics_ros.calibration.calibrate_robot import calibrate
from baxter_dynamics_ros.calibration.live import (
    COMMAND, ENVIRONMENT, progress, read_result, run, write_input)
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.simulation.exciting_trajectory import motion, SERIES
from calibration.known_robot import record
import numpy as np
import pytest


def written(path, recording):
    """Write the joint states of a recording as the input of the process; return its path."""
    rows = [(stamp, received, *arrays) for stamp, _, *arrays, received in recording.states]
    write_input(path, list(recording.states[0][1]), rows, PredictorSettings())
    return path


def test_process_calibrates_as_the_command_does(tmp_path):
    recording = record()
    found, wanted = run(written(tmp_path / 'states.npz', recording)), calibrate([recording])
    assert found.better and wanted.better
    assert found.message == wanted.summary
    assert found.notices == list(map(str, wanted.notices))
    assert found.rms_before == wanted.total.before.tolist()
    assert found.rms_after == wanted.total.after.tolist()
    before, after = wanted.before.parameters(), wanted.after.parameters()
    assert found.values == {name: value for name, value in after.items()
                            if value != before[name]}
    assert set(found.values) >= {'effort_model.coulomb', 'effort_model.bias',
                                 'effort_model.deviation'}


def test_process_gives_the_reason_of_a_refusal(tmp_path):
    source, output = written(tmp_path / 'states.npz', record(duration=8.0)), tmp_path / 'json'
    subprocess.run([*COMMAND, source, output], check=True, timeout=100,
                   env={**os.environ, **ENVIRONMENT})
    result = read_result(output)
    assert result.message.startswith('7.8 s of motion are too short')
    assert not result.better and not result.values and np.isnan(result.rms_after).all()


def test_progress_of_the_exciting_trajectory_grows_to_one():
    """At rest nothing is seen; the whole trajectory shows everything."""
    t = np.arange(0.0, 60.0, 0.01)
    q = motion(SERIES, t)[0]
    noise = np.random.default_rng(0).uniform(-2e-4, 2e-4, q.shape)
    shares = [progress(t[:n], q[:n] + noise[:n])[0] for n in (0, 1, 2, 500, 1500, 3000, 6000)]
    assert (np.diff(shares, axis=0) >= 0.0).all() and (shares[0] == 0.0).all()
    assert (shares[-1] == 1.0).all()
    assert progress(t, q)[1].startswith('all joints have moved enough')
    assert (progress(t, q[:1] + noise)[0] < 0.2).all()


@pytest.mark.parametrize('advice, change', [
    ('move e1 through more of the range', lambda t, q: 0.1 * q),
    ('move e1 faster in the negative direction', lambda t, q: 0.1 * np.maximum(t - 1.0, 0.0)),
    ('accelerate e1 more', lambda t, q: 3.0 * np.sin(0.1 * t)),
])
def test_advice_names_the_joint_and_the_missing_motion(advice, change):
    t = np.arange(0.0, 40.0, 0.01)
    q = np.sin(0.8 * t)[:, None] + np.zeros(7)
    q[:, 3] = change(t, q[:, 3])
    seen, said = progress(t, q)
    assert said == advice
    assert seen[3] < 1.0 and (np.delete(seen, 3) == 1.0).all()

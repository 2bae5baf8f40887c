"""Fitted to some recordings of a real arm, judged on the others by the node's own code."""

from dataclasses import dataclass
from functools import lru_cache

from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.effort import SPRING_COEFFICIENTS
from baxter_dynamics_ros.model.joints import joint_names, JOINTS
import numpy as np
import pytest

pytest.importorskip('scipy', reason='needs SciPy: pip install ".[offline]"')
pytest.importorskip('rosbags', reason='needs rosbags: pip install ".[offline]"')

from baxter_dynamics_ros.calibration.calibrate_robot import calibrate  # noqa: E402, I100
from baxter_dynamics_ros.recordings.playback import play  # noqa: E402
from baxter_dynamics_ros.recordings.reader import open_recordings  # noqa: E402

# RMS of what may be left over [N m].
OTHERS = np.array([0.60, 0.50, 0.45, 0.32, 0.11, 0.12, 0.08])
OTHERS_WITH_LINKS = np.array([0.50, 0.45, 0.42, 0.28, 0.10, 0.12, 0.08])
# Without the only recording of a wide motion, which is then among those left out:
NARROW = np.array([0.60, 0.55, 0.45, 0.32, 0.11, 0.12, 0.08])
NARROW_WITH_LINKS = np.array([0.50, 0.53, 0.42, 0.28, 0.10, 0.12, 0.08])
ELEVEN = np.array([0.65, 0.50, 0.50, 0.34, 0.12, 0.13, 0.09])
REST = np.array([0.60, 1.4, 1.6, 0.9, 0.45, 0.66, 0.13])
REST_WITH_LINKS = np.array([0.50, 1.4, 1.5, 0.55, 0.20, 0.22, 0.13])

SHARE = 0.7  # of the point-to-point recording that is fitted to


@dataclass(frozen=True, eq=False)
class Recording:
    """Joint states in memory."""

    name: str
    arm: str
    states: list

    def __iter__(self):
        return iter(self.states)


@lru_cache
def load(folder, name):
    """Return the recordings of a file."""
    result = []
    for opened in open_recordings([folder / f'baxter_{name}.npz']):
        with opened as one:
            result.append(Recording(one.name, one.arm, list(one)))
    return result


@lru_cache
def fitted(folder, left_out, inertial):
    """Return what tracking recordings give, but for every third one from ``left_out``."""
    return calibrate([one for i, one in enumerate(load(folder, 'left_arm_tracking'))
                      if i % 3 != left_out], inertial=inertial)


def left_over(values, recordings, start=0):
    """Return the RMS (7,) of the node's residual on recordings, each to a new node [N m]."""
    settings, parts = PredictorSettings(values), []
    for recording in recordings:
        predictor = settings.predictor()
        parts += [predictor.predict(block.estimate).residual
                  for block in play(recording.states[start:], predictor)]
        assert predictor.counts['predicted'] == len(recording.states[start:]) - 21
    left = np.sqrt(np.mean(np.concatenate(parts) ** 2, axis=0))
    print('left over [N m]:', left.round(3))
    return left


CASES = {'the wide one among the others': (1, False, OTHERS),
         'others left out': (2, False, OTHERS),
         'links': (1, True, OTHERS_WITH_LINKS),
         'the wide one left out': (0, False, NARROW),
         'the wide one left out, links': (0, True, NARROW_WITH_LINKS)}


@pytest.mark.parametrize('left_out, inertial, limit', CASES.values(), ids=CASES.keys())
def test_eight_tracking_recordings_tell_the_other_four(recordings, left_out, inertial, limit):
    found = fitted(recordings, left_out, inertial)
    others = load(recordings, 'left_arm_tracking')[left_out::3]
    assert len(others) == 4 and len(found.judged) == 8 and not found.by_time
    assert not {one.name for one in others} & {judged.name for judged in found.judged}
    left = left_over(found.values, others)
    assert (left < limit).all()
    assert (left < found.rms_before).all()


def test_a_message_at_a_time_the_node_says_the_same(recordings):
    values = fitted(recordings, 1, False).values
    one = load(recordings, 'left_arm_tracking')[4]
    assert max(values['effort_model.dahl']) > 0.1  # with friction that has a memory
    predictor = PredictorSettings(values).predictor()
    predictions = [predictor.handle(*state[:5]).prediction for state in one]
    residuals = np.array([p.residual for p in predictions if p is not None])
    np.testing.assert_allclose(np.sqrt(np.mean(residuals ** 2, axis=0)), left_over(values, [one]),
                               rtol=1e-9)


def test_what_it_says_of_data_left_out_is_what_is_left_on_others(recordings):
    """Cross-validated by recording: about as good as on four recordings it never saw."""
    found = fitted(recordings, 2, False)
    left = left_over(found.values, load(recordings, 'left_arm_tracking')[2::3])
    assert (found.rms_after < 1.5 * left).all() and (left < 1.5 * found.rms_after).all()
    assert (found.rms_after < found.rms_before).all()
    assert sum(len(one.states) for i, one in enumerate(load(recordings, 'left_arm_tracking'))
               if i % 3 != 2) == found.samples + 8 * 21


def test_one_recording_tells_the_other_eleven(recordings):
    all_ = load(recordings, 'left_arm_tracking')
    assert all_[0].name == 'Random'
    found = calibrate(all_[:1])
    assert found.by_time and [line for line in found.warnings if 'lap after lap' in line]
    assert (left_over(found.values, all_[1:]) < ELEVEN).all()


@pytest.mark.parametrize('inertial, limit', [(False, REST), (True, REST_WITH_LINKS)],
                         ids=['effort model', 'links'])
def test_the_first_part_of_a_wide_motion_tells_the_rest(recordings, inertial, limit):
    (whole,) = load(recordings, 'point_to_point')
    n = round(SHARE * len(whole.states))
    found = calibrate([Recording(whole.name, whole.arm, whole.states[:n])], inertial=inertial)
    assert (left_over(found.values, [whole], n) < limit).all()


def test_the_velocitys_lag_is_14_ms(recordings):
    found = [fitted(recordings, 1, False).lag,
             calibrate(load(recordings, 'point_to_point'), only=('bias',)).lag]
    for lag in found:
        assert lag.value == pytest.approx(0.014, abs=0.002)
        np.testing.assert_allclose(lag.per_joint, 0.014, atol=0.002)


def test_the_tracking_recordings_do_not_sweep_the_springs_range(recordings):
    """Their s1 stays in half of it: its shape fitted to them would be wrong elsewhere."""
    found = fitted(recordings, 1, False)
    assert [line for line in found.warnings if line.startswith('s1 sweeps -1.') and
            'its shape is kept' in line]
    ratio = np.divide(found.values['effort_model.spring_coefficients'],
                      found.before['effort_model.spring_coefficients'])
    np.testing.assert_allclose(ratio, ratio[0])


def test_bodies_stay_possible_and_near_what_they_were(recordings):
    """Plain least squares finds impossible masses in the same data."""
    values = fitted(recordings, 1, True).values
    arm = PredictorSettings(values).arm
    assert np.linalg.eigvalsh(arm.parameters.pseudo_inertia).min() > 0.0
    np.testing.assert_allclose(values['links.mass'], PredictorSettings().values['links.mass'],
                               rtol=0.3)
    tilt = np.degrees(np.arctan2(np.hypot(*values['gravity'][:2]), -values['gravity'][2]))
    assert 0.3 < tilt < 2.5


def test_the_terms_that_pay_on_a_real_arm(recordings):
    kept = {}
    for step in fitted(recordings, 1, False).steps:
        kept.setdefault(step.term, set()).update(JOINTS[i] for i in step.joints)
    assert kept['bias'] == set(JOINTS)
    assert kept['coulomb'] >= {'s0', 'e0', 'w0'}
    assert 's1' in kept['dahl']


@pytest.mark.timeout(120)
def test_the_springs_default_is_what_the_command_finds(recordings):
    both = load(recordings, 'left_arm_tracking') + [
        Recording(one.name, 'left', [state._replace(names=joint_names('left'))
                                     for state in one.states])
        for one in load(recordings, 'point_to_point')]
    found = calibrate(both, only=('spring', 'coulomb')).values
    np.testing.assert_allclose(found['effort_model.spring_coefficients'], SPRING_COEFFICIENTS,
                               atol=2e-3)

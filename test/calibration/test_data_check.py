"""Altered recordings: evaluate states what is wrong with numbers, calibrate refuses."""

import json

from baxter_dynamics_ros.calibration.calibrate_robot import calibrate
from baxter_dynamics_ros.calibration.fit_data import CalibrationError
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.recordings.playback import contact_rows, find_contacts
from calibration.known_robot import FRICTION, record, Recording, wander
import numpy as np
import pytest

pytest.importorskip('pinocchio', reason='needs Pinocchio: pip install pin')

from baxter_dynamics_ros.recordings.evaluate_recordings import Evaluator  # noqa: E402, I100

SETTINGS = PredictorSettings()
SWAPPED = np.array([0, 1, 3, 2, 4, 5, 6])  # e0 and e1


def dynamics(q, v):
    """Return M qdd + C qd (7,) [N m] as far as velocities alone give it, and G."""
    gravity = SETTINGS.model.arm.gravity(q)
    return SETTINGS.model.arm.inverse_dynamics(q, v, np.zeros(7)) - gravity, gravity


# What is done to position, velocity and effort of each joint state; the kind of the notice, its
# joints, and a part of its text.
ALTERED = {
    'effort negated': (lambda q, v, e: (q, v, -e), 'effort_sign', 'e1', 'e1 -'),
    'effort doubled': (lambda q, v, e: (q, v, 2.0 * e), 'effort_scale', 'e1', 'e1 2.0'),
    'efforts exchanged': (lambda q, v, e: (q, v, e[SWAPPED]), 'joints_exchanged', 'e1',
                          'efforts of e0, e1 look exchanged'),
    'joints exchanged': (lambda q, v, e: (q[SWAPPED], v[SWAPPED], e[SWAPPED]),
                         'joints_exchanged', 'e1', 'of e0, e1 look exchanged'),
    'zero joint': (lambda q, v, e: (q, v, e * (np.arange(7) != 3)), 'effort_constant', 'e1',
                   'measured effort is constant (e1 0.00 N m): record'),
    'gravity removed': (lambda q, v, e: (q, v, e - dynamics(q, v)[1]), 'no_gravity', 's1',
                        'gravity [0.0, 0.0, 0.0]'),
    'simulator without springs': (lambda q, v, e: (q, v, e - EffortModel().spring(q)),
                                  'no_springs', 's1', 'use simulation.yaml'),
    'velocity in degrees': (lambda q, v, e: (q, 0.2 * np.degrees(v), e), 'velocity_scale', '',
                            'check whether the period'),
    'faster in degrees': (lambda q, v, e: (q, np.degrees(v), e), 'implausible', '',
                          'check that the units are rad'),
    'velocity negated': (lambda q, v, e: (q, -v, e), 'velocity_scale', '', 'signs are reversed'),
}


@pytest.fixture(scope='module')
def sound():
    """Return a recording in which nothing is wrong."""
    return record(FRICTION, 3, 14.0)


def evaluate(recording):
    """Return an evaluation and its notices by kind."""
    found = Evaluator(SETTINGS).evaluate(recording)
    return found, {notice.kind: notice for notice in found.notices}


def test_sound_data_have_gains_of_one_and_no_notice(sound):
    found, notices = evaluate(sound)
    assert not notices.keys() & {'velocity_lag', *(kind for _, kind, *_ in ALTERED.values())}
    assert not found.contacts
    np.testing.assert_allclose(found.check.gain[:4], 1.0, atol=0.2)
    np.testing.assert_allclose(found.check.inertial.median(), 1.0, atol=0.1)
    assert found.check.velocity_scale == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize('name', ALTERED)
def test_altered_data_are_named_by_evaluate_and_refused_by_calibrate(name, sound):
    change, kind, joint, text = ALTERED[name]
    altered = sound.changed(change)
    notice = next(one for one in evaluate(altered)[0].notices if one.refuses)
    assert notice.kind == kind and text in str(notice), notice
    assert not joint or joint in notice.joints
    with pytest.raises(CalibrationError) as refusal:
        calibrate([altered])
    assert text in str(refusal.value)


def test_an_arm_at_rest_and_velocities_of_zero_have_no_lag(sound):
    t, q, effort = 10 ** 18, sound.states[0][2], sound.states[0][4]
    resting = Recording('rest', sound.arm, [
        (t + 10 ** 7 * i, sound.states[0][1], q, np.zeros(7), effort, t) for i in range(800)])
    for recording in (resting, sound.changed(lambda q, v, e: (q, 0.0 * v, e))):
        assert evaluate(recording)[0].check.lag is None


@pytest.mark.parametrize('share, springs, kind', [(-0.8, 0.0, 'effort_sign'),
                                                  (0.4, 0.9, 'springs'), (-0.8, 0.9, 'springs')])
def test_springs_that_the_settings_omit_are_no_error_of_unit_or_sign(sound, share, springs, kind):
    recording = sound.changed(lambda q, v, e: (q, v, np.where(
        np.arange(7) == 1, share * sum(dynamics(q, v)) + springs * EffortModel().spring(q), e)))
    found = Evaluator(SETTINGS.replace({'effort_model.enabled': False})).evaluate(recording)
    assert [problem.kind for problem in found.check.problems] == [kind]


@pytest.mark.parametrize('factor, text', [(2, 'is 2 times the true one'),
                                          (0.5, 'is 0.5 times the true one')])
def test_a_wrong_period_is_named(factor, text):
    altered = record(FRICTION, 3, 24.0)
    altered.states = [(round(10 ** 18 + factor * (stamp - 10 ** 18)), *rest)
                      for stamp, *rest in altered.states]
    assert text in evaluate(altered)[1]['velocity_scale'].remedy
    with pytest.raises(CalibrationError, match=text):
        calibrate([altered])


def test_an_arm_moved_by_hand_is_refused():
    """The hand supplies the inertial torque and friction, the motors the rest."""
    recording = record({}, 3, 20.0)
    t = np.array([state[0] for state in recording.states]) * 1e-9 - 1e9
    q, qd, qdd = wander(3, t)
    inertial = SETTINGS.model.arm.inverse_dynamics(q, qd, qdd) - SETTINGS.model.arm.gravity(q)
    pushed = recording.pushed(-inertial - 0.5 * np.tanh(qd / 0.05))
    notice = evaluate(pushed)[1]['moved_by_hand']
    assert 'friction is negative' in notice.finding and 's1' in notice.joints
    with pytest.raises(CalibrationError, match='moved by hand cannot be calibrated'):
        calibrate([pushed])


def test_contact_must_be_large_and_last_and_names_a_joint_stop():
    time = 0.01 * np.arange(1000)
    residual, q = np.full((1000, 7), 34.0), np.zeros((1000, 7))
    residual[200:300, 2] += 8.0  # at its stop
    residual[600:603, 3] += 8.0  # a spike
    residual[700:800, 1] += 3.0  # an error of the model
    q[190:310, 2] = -3.04
    (contact,) = find_contacts(time, residual, q, 'run')
    assert str(contact) == 'e0 at its stop, 8 N m, from 2.0 to 3.0 s of run'
    assert json.loads(json.dumps(contact)) == list(contact)  # as summary.json needs
    assert contact_rows(time, [contact]).sum() == pytest.approx(140, abs=3)

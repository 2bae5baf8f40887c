"""Altered recordings: evaluate states what is wrong with numbers, calibrate refuses."""

import json

from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.effort import EffortModel
from baxter_dynamics_ros.model.joints import JOINTS
from baxter_dynamics_ros.recordings.contact_intervals import contact_rows, find_contacts
from baxter_dynamics_ros.recordings.evaluate_recordings import Evaluator
import numpy as np
import pytest

pytest.importorskip('scipy', reason='needs SciPy: pip install ".[offline]"')
pytest.importorskip('pinocchio', reason='needs Pinocchio: pip install pin')

from baxter_dynamics_ros.calibration import fit  # noqa: E402, I100
from baxter_dynamics_ros.calibration.calibrate_robot import calibrate  # noqa: E402
from baxter_dynamics_ros.calibration.checks import CalibrationError  # noqa: E402

SETTINGS = PredictorSettings()
SWAPPED = np.array([0, 1, 3, 2, 4, 5, 6])  # e0 and e1


def dynamics(q, v):
    """Return M qdd + C qd (7,) [N m] as far as velocities alone give it, and G."""
    gravity = SETTINGS.model.arm.gravity(q)
    return SETTINGS.model.arm.inverse_dynamics(q, v, np.zeros(7)) - gravity, gravity


# What is done to position, velocity and effort of each joint state; the kind of the notice, its
# joints, and a part of its text.
ALTERED = {
    'effort negated': (lambda q, v, e: (q, v, -e), 'effort_sign', 'e1', 'correlation -'),
    'effort doubled': (lambda q, v, e: (q, v, 2.0 * e), 'effort_scale', 'e1', 'e1 2.0'),
    'effort in another unit': (lambda q, v, e: (q, v, 0.1 * e), 'effort_scale', 'e1', 'e1 0.1'),
    'efforts exchanged': (lambda q, v, e: (q, v, e[SWAPPED]), 'joints_exchanged', 'e1',
                          'efforts of e0, e1 look exchanged'),
    'joints exchanged': (lambda q, v, e: (q[SWAPPED], v[SWAPPED], e[SWAPPED]),
                         'joints_exchanged', 'e1', 'of e0, e1 look exchanged'),
    'zero joint': (lambda q, v, e: (q, v, e * (np.arange(7) != 3)), 'effort_constant', 'e1',
                   'effort of e1 is always 0 N m'),
    'gravity removed': (lambda q, v, e: (q, v, e - dynamics(q, v)[1]), 'no_gravity', 's1',
                        'gravity [0, 0, 0]'),
    'simulator without springs': (lambda q, v, e: (q, v, e - EffortModel().spring(q)),
                                  'no_springs', 's1', 'use simulation.yaml'),
    'velocity in degrees': (lambda q, v, e: (q, 0.2 * np.degrees(v), e), 'velocity_scale', '',
                            'check whether the period'),
    'velocity negated': (lambda q, v, e: (q, -v, e), 'velocity_scale', '', 'signs are opposite'),
}


@pytest.fixture(scope='module')
def sound(robot):
    """Return a recording in which nothing is wrong."""
    return robot.recording(robot.FRICTION, 3, 14.0)


def kinds(evaluation):
    return {notice.kind: notice for notice in evaluation.notices}


def evaluate(recording):
    recording.topic = '/robot/joint_states'
    return Evaluator(PredictorSettings()).evaluate(recording)


def test_sound_data_have_gains_of_one_and_no_notice(sound):
    found = evaluate(sound)
    assert not kinds(found).keys() & {kind for _, kind, *_ in ALTERED.values()}
    assert 'velocity_lag' not in kinds(found) and not found.contacts
    np.testing.assert_allclose(found.check.gain[:4], 1.0, atol=0.2)
    np.testing.assert_allclose(found.check.inertial.median(), 1.0, atol=0.1)
    assert found.check.velocity_scale == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize('name', ALTERED)
def test_altered_data_are_named_by_evaluate_and_refused_by_calibrate(name, sound):
    change, kind, joint, text = ALTERED[name]
    altered = sound.changed(change)
    notice = evaluate(altered).notices[0]
    assert notice.kind == kind and text in notice.text, notice
    assert not joint or joint in notice.joints
    with pytest.raises(CalibrationError) as refusal:
        calibrate([altered])
    assert text in str(refusal.value)


@pytest.mark.parametrize('factor, text', [(2, 'is 2 times the true one'),
                                          (0.5, 'is 0.5 times the true one')])
def test_a_wrong_period_is_named(robot, factor, text):
    sound = robot.recording(robot.FRICTION, 3, 24.0)
    altered = sound.part(None)
    altered.states = [(round(10 ** 18 + factor * (stamp - 10 ** 18)), *rest)
                      for stamp, *rest in sound.states]
    assert text in kinds(evaluate(altered))['velocity_scale'].text
    with pytest.raises(CalibrationError, match=text):
        calibrate([altered])


def test_implausible_velocities_are_refused(sound):
    altered = sound.changed(lambda q, v, e: (q, np.degrees(v), e))
    with pytest.raises(CalibrationError, match='check that the units are rad, rad/s'):
        calibrate([altered])


def test_an_arm_moved_by_hand_is_refused(robot):
    """The hand supplies the inertial torque and friction, the motors the rest."""
    recording = robot.recording({}, 3, 20.0)
    t = np.array([state[0] for state in recording.states]) * 1e-9 - 1e9
    q, qd, qdd = robot.wander(3, t)
    inertial = SETTINGS.model.arm.inverse_dynamics(q, qd, qdd) - SETTINGS.model.arm.gravity(q)
    push = inertial + 0.5 * np.tanh(qd / 0.05)
    recording.states = [(*state[:4], state[4] - row, state[5])
                        for state, row in zip(recording.states, push)]
    notice = kinds(evaluate(recording))['moved_by_hand']
    assert 'friction is negative' in notice.text and 's1' in notice.joints
    with pytest.raises(CalibrationError, match='moved by hand cannot be calibrated'):
        calibrate([recording])


def test_a_resting_arm_is_refused_whatever_the_noise_of_its_velocity(robot):
    def still(seed, t):
        q, qd, qdd = robot.wander(seed, t)
        return robot.CENTER + 0.0 * q, 0.0 * qd, 0.0 * qdd
    noisy = np.random.default_rng(0)
    recording = robot.recording({}, 3, 14.0, motion=still).changed(
        lambda q, v, e: (q, v + noisy.normal(0.0, 0.1, 7), e))
    assert evaluate(recording).check.lag is None
    with pytest.raises(CalibrationError, match='no joint moves faster than 0.0'):
        calibrate([recording])


def test_the_same_recording_twice_counts_once(robot):
    one, other = (robot.recording(robot.FRICTION, seed, 12.0) for seed in range(2))
    again = one.part(None)
    again.name = 'folder'
    found = calibrate([one, again, other], only=('bias',))
    assert [judged.name for judged in found.judged] == [one.name, other.name]
    (notice,) = [notice for notice in found.notices if notice.kind == 'duplicate']
    assert str(notice) == f'folder: holds the same data as {one.name}: counted once'


def test_a_large_offset_is_found_within_its_deviation(robot):
    truth = {**robot.FRICTION, 'effort_model.bias': (0.6, 34.0, 0.4, 0.3, -0.1, 0.12, 0.05)}
    found = calibrate([robot.recording(truth, seed, 12.0) for seed in range(2)])
    (bias,) = [one for one in found.of_term('bias') if one.joint == 1]
    assert abs(bias.value - 34.0) < 3 * bias.deviation < 1.0
    assert found.rms_after[1] < 1.1 * robot.LEAST[1]


def test_contact_is_found_and_left_out(robot):
    data = [robot.recording(robot.FRICTION, seed, 12.0) for seed in range(2)]
    pressed = data[0].part(None)
    pressed.states = [(*state[:4], state[4] + 9.0 * np.eye(7)[2] * (700 < i < 800), state[5])
                      for i, state in enumerate(data[0].states)]
    found, clean = (calibrate([one, data[1]], only=('bias', 'coulomb'))
                    for one in (pressed, data[0]))
    (contact,) = found.contacts
    assert contact.joint == 'e0' and not contact.at_stop and contact.recording == pressed.name
    assert contact.end - contact.start == pytest.approx(1.0, abs=0.2)
    assert abs(contact.peak) == pytest.approx(9.0, abs=1.0)
    np.testing.assert_allclose(found.rms_after, clean.rms_after, rtol=0.05)
    assert found.rms_with_contact[2] > 2 * found.rms_after[2]
    np.testing.assert_allclose(found.after.effort_model.bias,
                               clean.after.effort_model.bias, atol=0.02)
    assert evaluate(pressed).contacts[0].joint == 'e0'


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
    assert JOINTS[2] == contact.joint


def test_terms_that_predict_worse_are_given_up(robot, monkeypatch):
    data = [robot.recording(robot.FRICTION, seed, 12.0) for seed in range(2)]
    original = fit.fit_terms

    def spoiled(problem, step):
        found = original(problem, step)
        if step.term == 'coulomb':
            for one in found.judged:
                one.after[:] *= 30.0
        return found
    monkeypatch.setattr(fit, 'fit_terms', spoiled)
    found = calibrate(data, only=('bias', 'coulomb'))
    assert [step.term for step in found.steps] == ['', 'bias']
    assert not found.of_term('coulomb')
    (notice,) = [notice for notice in found.notices if notice.kind == 'given_up']
    assert 'with coulomb' in notice.text

"""Calibrations with doubtful data: undetermined parameters, refusals, lag, single terms."""

from baxter_dynamics_ros.calibration import fit
from baxter_dynamics_ros.calibration.calibrate_robot import calibrate
from baxter_dynamics_ros.calibration.fit_data import CalibrationError, observe
from baxter_dynamics_ros.estimation.settings import EffortModelSettings, PredictorSettings
from baxter_dynamics_ros.model import ArgumentError, JOINTS
from calibration.known_robot import (calibrated, CENTER, errors, FRICTION, LEAST, record,
                                     Recording, recordings, wander, warnings)
import numpy as np
import pytest

pytestmark = pytest.mark.filterwarnings('error')

ONLY = 'bias', 'coulomb'


def test_joints_that_do_not_reverse_are_named_and_keep_their_parameters():
    """The joints s1 and w2 rest, w0 starts from rest and turns one way."""
    def motion(seed, t):
        q, qd, qdd = wander(seed, t)
        q[:, (1, 6)] = CENTER[[1, 6]]
        qd[:, (1, 6)] = qdd[:, (1, 6)] = 0.0
        start = 0.1 * (1.0 - np.exp(-t))
        q[:, 4], qd[:, 4], qdd[:, 4] = 0.1 * t - start - 1.0, start, 0.1 * np.exp(-t)
        return q, qd, qdd
    found = calibrate([record(FRICTION, seed, motion=motion) for seed in range(2)])
    assert 's1, w2: never moves faster than 0.05 rad/s' in warnings(found)
    assert 'w0: moves in one direction only' in warnings(found)
    for joint in (1, 4, 6):
        (line,) = [line for line in warnings(found) if line.startswith(
            f'{JOINTS[joint]}: the motion does not determine')]
        for term in ('coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness'):
            assert getattr(found.after.effort_model, term)[joint] == 0.0, term
            assert term in line or (joint, term) == (1, 'stiffness')
    np.testing.assert_allclose(np.array(found.after.effort_model.coulomb)[[0, 2, 3, 5]],
                               np.array(FRICTION['effort_model.coulomb'])[[0, 2, 3, 5]],
                               atol=0.1)


@pytest.mark.parametrize('lag', [0.0, 0.03])
def test_velocity_lag_is_measured_and_adopted(lag):
    found = calibrate([record(FRICTION, seed, lag=lag) for seed in range(2)], only=ONLY)
    np.testing.assert_allclose([found.lag.value, *found.lag.per_joint], lag, atol=0.002)
    assert found.lag.uncertainty < 0.0005
    assert found.after.acceleration.velocity_lag == round(max(found.lag.value, 0.0), 4)
    assert found.before.acceleration.velocity_lag == found.after.acceleration.velocity_lag
    assert (found.total.after < 1.2 * LEAST).all()


def test_no_lag_without_velocities():
    found = calibrate([record().changed(
        lambda position, velocity, effort: (position, np.empty(0), effort))], only=('bias',))
    assert found.lag is None
    assert found.after.acceleration.velocity_lag == 0.014
    assert [line for line in warnings(found) if 'velocity_missing' in line]


def test_one_recording_is_split_by_time():
    """Its laps may repeat, which a warning states."""
    found = calibrated('friction', ONLY, 1)
    assert found.fold == 'part'
    assert [j.name for j in found.judged] == [f'motion 0, part {k}' for k in range(1, 6)]
    assert sum(j.duration for j in found.judged) == pytest.approx(23.8, abs=0.1)
    assert [line for line in warnings(found) if line.startswith('one recording: each of its '
            '5 parts ') and 'A repeated motion' in line]
    assert max(map(abs, errors(found, FRICTION).values())) < 3.0


def test_each_of_two_recordings_judges_the_other():
    """An offset of 1 N m at e0 in one recording is the error of both fits; a third is a copy."""
    one, other = recordings('friction')
    other = other.pushed([np.eye(7)[2]] * len(other.states))
    found = calibrate([one.part(0, 25, name='nothing'), one, one.part(name='copy'), other],
                      only=ONLY)
    assert found.fold == 'recording'
    assert [judged.name for judged in found.judged] == ['motion 0', 'motion 1']
    assert 'nothing: 0.0 s of motion are too short: left out' in warnings(found)
    assert 'copy: holds the same data as motion 0: counted once' in warnings(found)
    for judged in found.judged:
        assert judged.after[2] == pytest.approx(1.0, abs=0.02)
        assert (judged.after < LEAST)[[0, 1, 3, 4, 5, 6]].all()
    np.testing.assert_allclose([step.rms[2] for step in found.steps[1:]], [1.1, 1.0], atol=0.1)
    (bias,) = [p for p in found.of_term('bias') if p.joint == 2]
    assert bias.value == pytest.approx(0.9, abs=0.05)
    assert 0.3 < bias.deviation < 1.0


def test_a_large_offset_is_found_within_its_deviation():
    truth = {**FRICTION, 'effort_model.bias': (0.6, 34.0, 0.4, 0.3, -0.1, 0.12, 0.05)}
    found = calibrate([record(truth, seed) for seed in range(2)], only=ONLY)
    (bias,) = [one for one in found.of_term('bias') if one.joint == 1]
    assert abs(bias.value - 34.0) < 3 * bias.deviation < 1.0
    assert found.total.after[1] < 1.1 * LEAST[1]


def test_contact_is_found_and_left_out():
    one, other = recordings('friction')
    time = np.arange(len(one.states))[:, None]
    pressed = one.pushed(9.0 * np.eye(7)[2] * ((time > 700) & (time < 800)))
    found, clean = calibrate([pressed, other], only=ONLY), calibrated('friction', ONLY)
    (contact,) = found.contacts
    assert contact.joint == 'e0' and not contact.at_stop and contact.recording == pressed.name
    assert contact.end - contact.start == pytest.approx(1.0, abs=0.2)
    assert abs(contact.peak) == pytest.approx(9.0, abs=1.0)
    assert ' of ' not in str(calibrate([pressed], only=ONLY).contacts[0])  # not of a part
    np.testing.assert_allclose(found.total.after, clean.total.after, rtol=0.05)
    assert found.total.with_contact[2] > 2 * found.total.after[2]
    np.testing.assert_allclose(found.after.effort_model.bias,
                               clean.after.effort_model.bias, atol=0.02)
    often = one.pushed(9.0 * np.eye(7)[2] * (time // 100 % 2))
    large = str(warnings(calibrate([often, other], payload=True, only=ONLY)))
    assert 'too large for the model' in large and '--payload' not in large


@pytest.mark.parametrize('only', [(), ONLY], ids=['all terms', 'only'])
def test_terms_that_predict_worse_are_given_up_unless_asked_for(monkeypatch, only):
    class Spoiled(fit.Fit):

        def __init__(self, problem, step):
            super().__init__(problem, step)
            if step.term not in ('', 'bias'):
                for one in self.judged:
                    one.after[:] *= 30.0
    monkeypatch.setattr(fit, 'Fit', Spoiled)
    found = calibrate(recordings('friction'), only=only)
    given_up = [notice.finding for notice in found.notices if notice.kind == 'given_up']
    if only:
        assert found.of_term('coulomb') and not given_up
    else:
        assert [step.term for step in found.steps] == ['', 'bias']
        assert not found.of_term('coulomb')
        assert 'coulomb' in given_up[0] and 'predicted worse' in given_up[0]


def still(noise):
    """Return a recording of an arm at rest with noise in its velocity [rad/s]."""
    random = np.random.default_rng(0)
    return record(motion=lambda seed, t: (CENTER + np.zeros((len(t), 7)), *np.zeros((
        2, len(t), 7)))).changed(lambda q, v, e: (q, v + random.normal(0.0, noise, 7), e))


REFUSED = {
    'no recordings': lambda: [],
    'no joint moves faster than 0.0': lambda: [still(noise=0.1)],
    'measured effort is exactly zero': lambda: [record().changed(lambda q, v, e: (q, v, 0.0 * e))],
    'no measured effort': lambda: [record().changed(lambda q, v, e: (q, v, e[:0]))],
    'the fit leaves the range of a parameter: effort_model.bias': lambda: [record().changed(
        lambda q, v, e: (q, v, e + 60.0))],
    'both arms: calibrate one': lambda: [
        record({'arm': side}, duration=1.0) for side in ('left', 'right')],
    'no valid joint states of the arm': lambda: [
        Recording('other', 'left', record({'arm': 'right'}).states)],
}


@pytest.mark.parametrize('reason', REFUSED)
def test_useless_recordings_are_refused_with_the_reason(reason):
    with pytest.raises(CalibrationError, match=reason) as caught:
        calibrate(REFUSED[reason]())
    assert '\n' not in str(caught.value)


def test_duration_of_a_looping_bag_is_that_of_its_laps():
    """The stamps jump back between the laps."""
    one = record()
    one.states = one.states + one.states
    assert observe(one, PredictorSettings()).duration == pytest.approx(2 * 11.8, abs=0.1)
    found = calibrate([one], only=('bias',))
    assert [line for line in warnings(found) if 'reset_clock_jump' in line]


def test_only_fits_the_named_terms_and_reports_the_stages():
    stages = []
    found = calibrate(recordings('friction'), only=('coulomb',), progress=stages.append)
    assert [step.term for step in found.steps] == ['', 'coulomb']
    assert found.steps[1].joints == tuple(range(7))
    changed = {name for name, value in found.after.parameters().items()
               if value != found.before.parameters()[name]}
    assert {name for name in changed if 'deviation' not in name} == {'effort_model.coulomb'}
    assert stages == ['reading motion 0', 'reading motion 1', 'fitting', 'cross-validating']


@pytest.mark.parametrize('arguments, message', [
    ({'only': ('colomb',)}, 'no term colomb; there are added_inertia, bias'),
    ({'settings': PredictorSettings(effort_model=EffortModelSettings(enabled=False))},
     'effort_model.enabled: false'),
    ({'settings': PredictorSettings(align=False)}, 'align: false')])
def test_unusable_arguments_are_refused_by_name(arguments, message):
    with pytest.raises(ArgumentError, match=message):
        calibrate(recordings('friction'), **arguments)

"""Calibration of a robot with known parameters: they are found within their uncertainty."""

from dataclasses import replace

from baxter_dynamics_ros.calibration import calibrate_robot
from baxter_dynamics_ros.calibration.calibrate_robot import calibrate
from baxter_dynamics_ros.calibration.fit import choose, Fit
from baxter_dynamics_ros.calibration.fit_data import observe, residual
from baxter_dynamics_ros.calibration.least_squares import Problem
from baxter_dynamics_ros.calibration.terms import Links
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model import JOINTS, rms
from baxter_dynamics_ros.model.effort import SPRING_COEFFICIENTS
from calibration.known_robot import (ALL, calibrated, CENTER, columns, errors, FRICTION, kept,
                                     LEAST, make_motion, record, recordings, updated, wander,
                                     warnings)
import numpy as np
import pytest

pytestmark = pytest.mark.filterwarnings('error')

# Largest uncertainty of parameters that the motion shows well.
LIMITS = {'bias': 0.15, 'coulomb': 0.15, 'viscous': 0.1, 'dahl': 0.15, 'added_inertia': 0.05,
          'stiffness': 0.15, 'tilt': 0.015}


def assert_true_within_uncertainty(found, truth):
    off = errors(found, truth)
    print({name: round(error, 1) for name, error in off.items()})
    assert max(map(abs, off.values())) < 3.0
    return off


def test_all_terms_are_found_within_their_uncertainty():
    found = calibrated('all')
    off = assert_true_within_uncertainty(found, ALL)
    assert 0.05 < np.sqrt(np.mean(np.square(list(off.values())))) < 1.5
    for parameter in found.parameters:
        assert parameter.deviation < LIMITS.get(parameter.term, np.inf), parameter
    joints = kept(found)
    for name, values in ALL.items():
        term = name.partition('.')[2]
        for joint, value in zip(JOINTS, values):
            assert not term or not value or joint in joints[term], (term, joint)
    assert joints['tilt'] == JOINTS
    assert found.after.effort_model.dahl_length == 0.02


def test_absent_terms_are_not_fitted():
    found = calibrated('friction')
    joints = kept(found)
    assert joints.pop('bias') == JOINTS
    assert set(joints.pop('coulomb')) == set(JOINTS) - {'e1'}
    # At the wrist the noise is so small that the filter's effect on sharp friction shows.
    assert set().union(*joints.values()) <= {'w0', 'w1', 'w2'}
    assert_true_within_uncertainty(found, FRICTION)
    before, after = found.before, found.after
    assert after.gravity == before.gravity and after.links == before.links
    assert (after.effort_model.crosstalk == before.effort_model.crosstalk).all()
    assert after.acceleration.velocity_lag == 0.014  # as usual, and as measured


def test_left_out_residual_is_noise_of_the_expected_deviation():
    found = calibrated('friction')
    assert (found.total.after < LEAST).all()
    assert (found.total.before > 2.0 * found.total.after).all()
    np.testing.assert_allclose(found.steps[0].rms, found.total.before, rtol=0.05)
    assert found.samples == sum(len(r.states) - 21 for r in recordings('friction'))
    assert found.total.duration == pytest.approx(0.01 * (found.samples - 2), rel=1e-3)
    for judged, one in zip(found.judged, recordings('friction')):
        left = rms(residual(observe(one, found.after), found.after))
        np.testing.assert_allclose(judged.after, left, rtol=0.05)
    motion = observe(record(FRICTION, 9), found.after)
    expected = found.after.model.effort_model.deviation_at(motion.qd, motion.qdd)
    covered = (np.abs(residual(motion, found.after)) < 1.96 * expected).mean(0)
    np.testing.assert_array_less(np.abs(covered - 0.95), 0.05)


def test_residual_of_a_motion_is_that_of_the_node():
    values = {**ALL, 'arm': 'right', 'effort_model.coulomb_velocity': 0.1}
    one = record(values, 7)
    one.states = one.states[:500] + one.states[560:]  # the filter restarts after the gap
    settings = PredictorSettings.from_parameters(values)
    predictor = Predictor(settings)
    node = [step.prediction for step in (predictor.handle(*state[:5]) for state in one)
            if step.prediction]
    motion = observe(one, settings)
    np.testing.assert_allclose(residual(motion, settings), [p.residual for p in node], atol=1e-9)
    np.testing.assert_array_equal(motion.time,
                                  [(p.stamp_ns - node[0].stamp_ns) * 1e-9 for p in node])
    assert len(motion.segments) == 2


def test_crosstalk_is_found_where_it_is():
    """From the default, e1 has more of e0, and s1 something of e0."""
    crosstalk = np.zeros((7, 7))
    crosstalk[3, 2], crosstalk[1, 2] = -0.06, 0.08
    truth = {**FRICTION, 'effort_model.crosstalk': crosstalk.ravel()}
    data = [record(truth, seed, 20.0) for seed in range(3)]
    found = calibrate(data[:2])
    assert kept(found)['crosstalk'] == ('s1', 'e1')
    assert_true_within_uncertainty(found, truth)
    (s1, e1) = found.of_term('crosstalk')
    assert (s1.joint, s1.component, e1.joint, e1.component) == (1, 'of e0', 3, 'of e0')
    assert max(s1.deviation, e1.deviation) < 0.02
    left = residual(observe(data[2], found.after), found.after)
    assert (rms(left) < 1.2 * LEAST).all()


def test_a_touch_hardly_changes_the_fit(monkeypatch):
    """It is too weak to be left out as contact."""
    only = ('bias', 'coulomb')
    one, other = recordings('friction')
    time = np.arange(len(one.states))[:, None]
    touched = one.pushed(3.0 * np.eye(7)[2] * ((time > 700) & (time < 900)))
    robust = calibrate([touched, other], only=only)
    monkeypatch.setattr(calibrate_robot, '_robust', lambda *_: None)
    plain = calibrate([touched, other], only=only)
    assert not robust.contacts and not plain.contacts
    clean = calibrated('friction', only).after.effort_model.bias[2]
    error, usual = (abs(each.after.effort_model.bias[2] - clean) for each in (robust, plain))
    assert usual > 0.08 and error < 0.2 * usual


def test_spring_gets_a_gain_if_s1_sweeps_little():
    def motion(seed, t):
        q, qd, qdd = wander(seed, t)
        return CENTER + 0.5 * (q - CENTER), 0.5 * qd, 0.5 * qdd
    truth = {**FRICTION, 'effort_model.spring_coefficients': 1.1 * np.array(SPRING_COEFFICIENTS)}
    found = calibrate([record(truth, seed, 20.0, motion=motion) for seed in range(2)],
                      only=('bias', 'spring', 'coulomb'))
    (line,) = [line for line in warnings(found) if 'its shape is kept' in line]
    low, high = (float(line.split()[i]) for i in (2, 4))
    assert -1.2 < low < -0.8 and 0.0 < high < 0.3
    (gain,) = found.of_term('spring')
    assert (gain.component, gain.before) == ('gain', pytest.approx(1.0))
    assert abs(gain.value - 1.1) < 3 * gain.deviation and gain.deviation < 0.05
    np.testing.assert_allclose(np.array(found.after.effort_model.spring_coefficients)
                               / SPRING_COEFFICIENTS, gain.value)


def test_a_wrong_calibration_is_corrected():
    wrong = {'effort_model.coulomb': (2.0,) * 3 + (0.4,) * 4, 'effort_model.dahl': (1.0,) * 7,
             'effort_model.bias': (1.0,) * 7, 'effort_model.dahl_length': 0.02,
             'effort_model.viscous': (0.5,) * 7, 'arm': 'left'}
    found = calibrate(recordings('friction'), PredictorSettings.from_parameters(wrong))
    assert (found.before.effort_model.bias == 1.0).all() and found.before.arm == 'right'
    assert (found.total.after < 1.1 * calibrated('friction').total.after).all()
    assert found.after.effort_model.dahl_length == 0.02
    for name in ('coulomb', 'dahl', 'viscous'):
        true = FRICTION.get(f'effort_model.{name}', (0.0,) * 7)
        np.testing.assert_allclose(getattr(found.after.effort_model, name), true, atol=0.1,
                                   err_msg=name)


def test_links_are_found_as_far_as_the_motion_shows_them():
    """Few of the 70 parameters are determined; the prediction and the uncertainties must hold."""
    settings = PredictorSettings.from_parameters({**FRICTION, 'gravity': ALL['gravity']})
    truth = updated(Links(settings.model.arm), settings,
                    np.random.default_rng(4).normal(0.0, 0.05, 70)).parameters()
    found = calibrate([record(truth, seed, 24.0) for seed in range(2)],
                      only=('bias', 'coulomb', 'tilt'), inertial=True)
    assert_true_within_uncertainty(found, truth)
    assert (found.total.after < LEAST).all()
    assert len(found.of_term('inertial')) == 28
    left = residual(observe(record(truth, 9), found.after), found.after)
    assert (rms(left) < 1.2 * LEAST).all()


def test_links_stay_possible_whatever_the_data_show():
    """A forearm of negative mass would explain these data best."""
    settings, rng = PredictorSettings(), np.random.default_rng(2)
    links = Links(settings.model.arm)
    wanted = np.zeros((7, 10))
    wanted[3, [n for n, (i, k) in enumerate(zip(*np.triu_indices(4))) if i == k]] = -2.0
    assert links.least_eigenvalues(wanted.ravel())[3] == pytest.approx(-1.0)
    motions = []
    for motion in (make_motion(1500, rng), make_motion(1500, rng)):
        tau = settings.model.arm.inverse_dynamics(motion.q, motion.qd, motion.qdd)
        effort = settings.model.effort_model.effort(tau, motion.q, motion.qd, motion.qdd)
        effort = effort + columns(links, settings, motion) @ wanted.ravel()
        noise = rng.normal(0.0, 0.05, effort.shape)
        motions.append(replace(motion, time=10 * motion.time, effort=effort + noise))
    problem = Problem(settings, [links], motions)
    steps, *_ = choose(problem, {'inertial'})
    found = Fit(problem, steps[-1]).settings  # is not refused
    assert np.linalg.eigvalsh(found.model.arm.parameters.pseudo_inertia).min() > 0.0
    assert found.links.mass[3] < 0.2 * settings.links.mass[3]

"""A robot whose every number is known: the fit finds it, says how well, and what it cannot tell."""

from functools import lru_cache

from baxter_dynamics_ros.core.effort import SPRING_COEFFICIENTS
from baxter_dynamics_ros.core.exceptions import ArgumentError
from baxter_dynamics_ros.core.joints import joint_names
from baxter_dynamics_ros.core.joints import JOINTS
from baxter_dynamics_ros.core.presliding import Presliding
from baxter_dynamics_ros.signals.settings import DEFAULTS
from baxter_dynamics_ros.signals.settings import PredictorSettings
import numpy as np
import pytest

pytest.importorskip('scipy', reason='needs SciPy: pip install ".[offline]"')

from baxter_dynamics_ros.calibration.calibrate import calibrate  # noqa: E402, I100
from baxter_dynamics_ros.calibration.checks import CalibrationError  # noqa: E402
from baxter_dynamics_ros.calibration.fit import residual  # noqa: E402
from baxter_dynamics_ros.calibration.motion import observe  # noqa: E402
from baxter_dynamics_ros.calibration.terms import Links  # noqa: E402

pytestmark = pytest.mark.filterwarnings('error')

PERIOD = 0.01  # [s]
FINE = 5  # steps of the true motion in a period: Dahl's friction sees each turn
EFFORT_NOISE = np.array([0.075, 0.037, 0.075, 0.035, 0.008, 0.016, 0.011])  # sd [N m]
VELOCITY_NOISE = 0.004  # sd [rad/s]
POSITION_NOISE = 4e-4  # sd [rad]
CENTER = np.array([0.0, -0.45, 0.0, 1.2, 0.0, 0.4, 0.0])  # [rad]

# What a robot may have; other joints than those named have none of it.
TRUTH = {
    'effort_model.coulomb': (0.8, 1.0, 0.4, 0.0, 0.15, 0.12, 0.04),
    'effort_model.viscous': (0.0, 0.4, 0.0, 0.0, 0.1, 0.0, 0.0),
    'effort_model.dahl': (0.5, 1.2, 0.0, 0.3, 0.0, 0.0, 0.02),
    'effort_model.bias': (0.6, -0.5, 0.4, 0.3, -0.1, 0.12, 0.05),
    'effort_model.added_inertia': (0.25, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0),
    'effort_model.stiffness': (-0.5, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0),
    'gravity': (0.15, -0.12, -9.8081),
}
FRICTION = {name: TRUTH[name] for name in ('effort_model.coulomb', 'effort_model.bias')}
# How uncertain a parameter may be where the motion shows it well.
LIMITS = {'bias': 0.15, 'coulomb': 0.15, 'viscous': 0.1, 'dahl': 0.15, 'added_inertia': 0.05,
          'stiffness': 0.15, 'gravity': 0.015}


class Recording:
    """Joint states in memory, which can be read again and again."""

    def __init__(self, name, arm, states):
        self.name = name
        self.arm = arm
        self.states = states

    def __iter__(self):
        return iter(self.states)

    def changed(self, change):
        """Return it with each position, velocity and effort as ``change`` makes them."""
        return Recording(self.name, self.arm, [
            (stamp, names, *change(*arrays), received)
            for stamp, names, *arrays, received in self.states])

    def part(self, *span):
        """Return some of it."""
        return Recording(self.name, self.arm, self.states[slice(*span)])


def wander(seed, t):
    """Return q, qd, qdd, each (n, 7), of a motion that turns all joints round; t (n,) [s]."""
    rng = np.random.default_rng(seed)
    w = 2 * np.pi * rng.uniform(0.03, 0.5, (4, 7))  # [rad/s]
    amplitude = np.array([0.35, 0.42, 0.35, 0.35, 0.42, 0.35, 0.42]) * np.minimum(1.0, 1.5 / w)
    angle = w * t[:, None, None] + rng.uniform(0.0, 6.28, (4, 7))
    return (CENTER + (amplitude * np.sin(angle)).sum(1), (amplitude * w * np.cos(angle)).sum(1),
            -(amplitude * w ** 2 * np.sin(angle)).sum(1))


def recording(truth, seed, duration=40.0, lag=0.014, motion=wander, noise=1.0):
    """Return what a robot with these settings publishes: its own effort, and white noise."""
    rng = np.random.default_rng(seed)
    settings = PredictorSettings(truth)
    fine = PERIOD / FINE * np.arange(round(duration / PERIOD) * FINE)
    state = Presliding(settings.effort_model.dahl_length)
    presliding = np.array([state.update(q) for q in motion(seed, fine)[0]])[::FINE]
    t = fine[::FINE]
    q, qd, qdd = motion(seed, t)
    effort = settings.effort_model.effort(
        settings.arm.inverse_dynamics(q, qd, qdd), q, qd, qdd, presliding)
    effort = effort + noise * EFFORT_NOISE * rng.standard_normal(q.shape)
    velocity = motion(seed, t - lag)[1] + noise * VELOCITY_NOISE * rng.standard_normal(q.shape)
    position = q + noise * POSITION_NOISE * rng.standard_normal(q.shape)
    names = joint_names(settings.values['arm'])
    stamps = 10 ** 18 + np.round(1e9 * t).astype(int)
    return Recording(f'motion {seed}', settings.values['arm'], [
        (stamp, names, *arrays, stamp)
        for stamp, *arrays in zip(stamps.tolist(), position, velocity, effort)])


@lru_cache
def recordings(kind):
    """Return four recordings of a robot that is known."""
    truth = {'all': TRUTH, 'friction': FRICTION}[kind]
    return [recording(truth, seed) for seed in range(4)]


@lru_cache
def calibrated(kind):
    """Return what is found in them."""
    return calibrate(recordings(kind))


def true_value(parameter, truth):
    """Return what a parameter should be."""
    values = {**DEFAULTS, **truth}
    kind, _, which = parameter.name.partition(' ')
    if kind == 'gravity':
        return values['gravity']['xyz'.index(which)]
    if kind == 'spring':
        names = ('1', 'sin q', 'cos q', 'sin 2q', 'cos 2q')
        gain = values['effort_model.spring_coefficients'][2] / SPRING_COEFFICIENTS[2]
        return gain if which == 'gain' else values['effort_model.spring_coefficients'][
            names.index(which)]
    if kind == 'link':
        link, _, what = which.partition(' ')
        link = int(link) - 1
        mass = values['links.mass'][link]
        return mass if what == 'mass' else mass * values['links.center_of_mass'][
            3 * link + 'xyz'.index(what[-1])]
    if kind == 'payload':
        return (values['payload.mass'] if which == 'mass' else
                values['payload.center_of_mass']['xyz'.index(which[-1])])
    return values[f'effort_model.{kind}'][JOINTS.index(which)]


def off(calibration, truth) -> dict:
    """Return how many times its uncertainty each parameter is off the truth, by name."""
    return {p.name: (p.after - true_value(p, truth)) / p.uncertainty
            for p in calibration.parameters}


def kept(calibration) -> dict:
    """Return the joints where each term was kept."""
    return {step.term: tuple(JOINTS[i] for i in step.joints) for step in calibration.steps[1:]}


def test_the_truth_is_found_within_its_uncertainty():
    found = calibrated('all')
    errors = off(found, TRUTH)
    print({name: round(error, 1) for name, error in errors.items()})
    assert max(map(abs, errors.values())) < 3.0
    assert 0.05 < np.sqrt(np.mean(np.square(list(errors.values())))) < 1.5
    for parameter in found.parameters:
        limit = LIMITS.get(parameter.name.split()[0])
        assert limit is None or parameter.uncertainty < limit, parameter.name


def test_what_there_is_is_fitted():
    found = kept(calibrated('all'))
    for name, values in TRUTH.items():
        term = name.partition('.')[2]
        for joint, value in zip(JOINTS, values):
            if term and value:
                assert joint in found[term], (term, joint)
    assert found['tilt'] == JOINTS
    assert calibrated('all').values['effort_model.dahl_length'] == 0.02


def test_what_there_is_not_is_not_fitted():
    found = calibrated('friction')
    joints = kept(found)
    assert joints.pop('bias') == JOINTS
    assert set(joints.pop('coulomb')) == set(JOINTS) - {'e1'}
    assert set(joints.values()) == {()}
    assert max(map(abs, off(found, FRICTION).values())) < 3.0
    for name, value in found.values.items():
        if name not in FRICTION:
            np.testing.assert_array_equal(value, found.before[name], err_msg=name)
    assert found.values['effort_model.coulomb'][3] == 0.0


def test_what_is_left_on_data_left_out_is_the_noise():
    found = calibrated('friction')
    assert (found.rms_after < 1.3 * EFFORT_NOISE + 0.03).all()
    assert (found.rms_before > 2.0 * found.rms_after).all()
    assert found.samples == sum(len(r.states) - 21 for r in recordings('friction'))
    assert found.duration == pytest.approx(0.01 * (found.samples - 4), rel=1e-3)
    left = [residual(observe(r, found.values), found.values) for r in recordings('friction')]
    for judged, one in zip(found.judged, left):
        np.testing.assert_allclose(judged.after, np.sqrt(np.mean(one ** 2, axis=0)), rtol=0.05)


def test_each_step_tells_what_its_term_bought():
    steps = calibrated('friction').steps
    assert [step.term for step in steps][:2] == ['', 'bias']
    np.testing.assert_allclose(steps[0].rms, calibrated('friction').rms_before, rtol=0.01)
    for before, after in zip(steps, steps[1:]):
        assert (after.rms < (1.0 + 1e-9) * before.rms)[list(after.joints)].all()
        others = [i for i in range(7) if i not in after.joints]
        np.testing.assert_array_equal(after.rms[others], before.rms[others])


def test_the_residual_of_a_motion_is_the_nodes():
    values = {**TRUTH, 'arm': 'right', 'effort_model.coulomb_velocity': 0.1}
    one = recording(values, 7, 12.0)
    one.states = one.states[:500] + one.states[560:]  # a gap: the filter starts anew
    predictor = PredictorSettings(values).predictor()
    node = [p for p in (predictor.handle(*state[:5]) for state in one) if p is not None]
    motion = observe(one, values)
    np.testing.assert_allclose(residual(motion, values), [p.residual for p in node], atol=1e-9)
    np.testing.assert_array_equal(motion.time,
                                  [(p.stamp_ns - node[0].stamp_ns) * 1e-9 for p in node])
    assert len(motion.segments) == 2


@pytest.mark.parametrize('held', [(4,), (1, 6)], ids=['w0', 's1, w2'])
def test_joints_that_do_not_move_are_named_and_keep_what_they_had(held):
    def motion(seed, t):
        q, qd, qdd = wander(seed, t)
        q[:, held] = CENTER[list(held)]
        qd[:, held] = qdd[:, held] = 0.0
        return q, qd, qdd
    found = calibrate([recording(FRICTION, seed, 25.0, motion=motion) for seed in range(2)])
    names = ', '.join(JOINTS[i] for i in held)
    assert f'{names}: never moves faster than 0.05 rad/s' in found.warnings
    for joint in held:
        (line,) = [line for line in found.warnings if line.startswith(
            f'{JOINTS[joint]}: the motion does not show')]
        assert 'coulomb' in line and 'viscous' in line and 'dahl' in line, line
        for term in ('coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness'):
            assert found.values[f'effort_model.{term}'][joint] == 0.0, term
    others = [i for i in range(7) if i not in held]
    np.testing.assert_allclose(np.array(found.values['effort_model.coulomb'])[others],
                               np.array(FRICTION['effort_model.coulomb'])[others], atol=0.1)


def test_a_joint_that_turns_one_way_does_not_show_its_friction():
    def motion(seed, t):
        q, qd, qdd = wander(seed, t)
        start = 0.1 * (1.0 - np.exp(-t))  # it starts from rest, and goes on
        q[:, 4], qd[:, 4], qdd[:, 4] = 0.1 * t - start - 1.0, start, 0.1 * np.exp(-t)
        return q, qd, qdd
    found = calibrate([recording(FRICTION, seed, 20.0, motion=motion) for seed in range(2)])
    assert 'w0: turns one way only' in found.warnings
    (line,) = [line for line in found.warnings if line.startswith('w0: the motion does not show')]
    assert 'coulomb' in line and 'dahl' in line, line
    assert found.values['effort_model.coulomb'][4] == found.values['effort_model.dahl'][4] == 0.0


def test_without_a_sweep_of_s1_its_springs_shape_is_kept():
    def motion(seed, t):
        q, qd, qdd = wander(seed, t)
        return CENTER + 0.5 * (q - CENTER), 0.5 * qd, 0.5 * qdd
    truth = {**FRICTION, 'effort_model.spring_coefficients': 1.1 * np.array(SPRING_COEFFICIENTS)}
    found = calibrate([recording(truth, seed, motion=motion) for seed in range(3)])
    (line,) = [line for line in found.warnings if 'its shape is kept' in line]
    low, high = (float(line.split()[i]) for i in (2, 4))
    assert -1.2 < low < -0.9 and 0.0 < high < 0.3
    assert kept(found)['spring'] == ('s1',)
    (gain,) = [p for p in found.parameters if p.term == 'spring']
    assert (gain.name, gain.before) == ('spring gain', pytest.approx(1.0))
    assert abs(gain.after - 1.1) < 3 * gain.uncertainty and gain.uncertainty < 0.05
    np.testing.assert_allclose(np.array(found.values['effort_model.spring_coefficients'])
                               / SPRING_COEFFICIENTS, gain.after)


def test_with_a_sweep_of_s1_the_springs_shape_is_fitted():
    def motion(seed, t):
        q, qd, qdd = wander(seed, t)
        angle = 0.4 * t + seed
        q[:, 1], qd[:, 1], qdd[:, 1] = (
            -0.45 + 1.5 * np.sin(angle), 0.6 * np.cos(angle), -0.24 * np.sin(angle))
        return q, qd, qdd
    truth = {**FRICTION, 'effort_model.spring_coefficients': (-3.0, -8.0, 30.0, 8.5, 4.5)}
    found = calibrate([recording(truth, seed, motion=motion) for seed in range(3)])
    assert not [line for line in found.warnings if 'its shape is kept' in line]
    assert len([p for p in found.parameters if p.term == 'spring']) == 4
    angle = np.zeros((60, 7))
    angle[:, 1] = np.linspace(-1.85, 0.95, 60)
    true, fitted = (PredictorSettings(v).effort_model.spring(angle)[:, 1]
                    + PredictorSettings(v).effort_model.bias[1] for v in (truth, found.values))
    np.testing.assert_allclose(fitted, true, atol=0.15)


@pytest.mark.parametrize('lag, taken', [(0.0, True), (0.014, False), (0.03, True)])
def test_the_velocitys_lag_is_measured_and_taken_over(lag, taken):
    found = calibrate([recording(FRICTION, seed, 20.0, lag) for seed in range(2)])
    assert found.lag.value == pytest.approx(lag, abs=0.001)
    np.testing.assert_allclose(found.lag.per_joint, lag, atol=0.002)
    assert found.lag.uncertainty < 0.0005
    value = found.values['acceleration.velocity_lag']
    assert value == found.before['acceleration.velocity_lag']
    assert value == (pytest.approx(lag, abs=0.001) if taken else 0.014)
    assert (found.rms_after < 2.0 * EFFORT_NOISE + 0.05).all()


def test_without_velocities_there_is_no_lag():
    def blind(position, velocity, effort):
        return position, np.empty(0), effort
    found = calibrate([recording(FRICTION, 0, 20.0).changed(blind)])
    assert found.lag is None
    assert found.values['acceleration.velocity_lag'] == 0.014
    assert [line for line in found.warnings if 'velocity_missing' in line]


def test_one_recording_is_split_by_time_and_says_that_laps_repeat():
    one = recording(FRICTION, 0)
    found = calibrate([one])
    assert found.by_time
    assert [j.name for j in found.judged] == [f'motion 0, part {k}' for k in range(1, 6)]
    assert sum(j.duration for j in found.judged) == pytest.approx(39.8, abs=0.1)
    assert [line for line in found.warnings if line.startswith('one recording: judged on each of '
            '5 parts of it') and 'lap after lap' in line]
    assert max(map(abs, off(found, FRICTION).values())) < 3.0


def test_two_recordings_judge_each_other():
    pair = recordings('friction')[:2]
    found = calibrate(pair)
    assert not found.by_time
    assert [j.name for j in found.judged] == ['motion 0', 'motion 1']
    assert not [line for line in found.warnings if 'lap' in line]
    for judged, other in zip(found.judged, pair[::-1]):
        alone = calibrate([other], only=[step.term for step in found.steps[1:] if step.joints])
        one = next(r for r in pair if r.name == judged.name)
        left = residual(observe(one, alone.values), alone.values)
        np.testing.assert_allclose(judged.after, np.sqrt(np.mean(left ** 2, axis=0)), rtol=0.1)


def test_a_recording_without_the_arm_does_not_stop_the_others():
    empty = recording(FRICTION, 0, 1.0).part(0, 5)
    empty.name = 'nothing'
    found = calibrate([empty, *recordings('friction')[:2]])
    assert [j.name for j in found.judged] == ['motion 0', 'motion 1']
    assert 'nothing: 0.0 s of motion are too short: left out' in found.warnings


def still(seed, t):
    """Return a motion of joints that hang still but for a tremble."""
    q, qd, qdd = wander(seed, t)
    return CENTER + 0.01 * (q - CENTER), 0.01 * qd, 0.01 * qdd


REFUSED = {
    'no recordings': lambda: [],
    'too short': lambda: [recording(FRICTION, 0, 9.0)],
    'no joint moves': lambda: [recording(FRICTION, 0, 15.0, motion=still)],
    'measured effort is exactly zero': lambda: [
        recording(FRICTION, 0, 12.0).changed(lambda q, qd, effort: (q, qd, 0.0 * effort))],
    'no measured effort': lambda: [
        recording(FRICTION, 0, 12.0).changed(lambda q, qd, effort: (q, qd, np.empty(0)))],
    'both arms': lambda: [recording({'arm': side}, 0, 12.0) for side in ('left', 'right')],
    'no valid joint states of the arm': lambda: [Recording('other', 'left', recording(
        {'arm': 'right'}, 0, 12.0).states)],
}


@pytest.mark.parametrize('reason', REFUSED)
def test_what_cannot_be_fitted_to_is_refused_with_the_reason(reason):
    given = REFUSED[reason]()
    with pytest.raises(CalibrationError, match=reason) as caught:
        calibrate(given)
    assert '\n' not in str(caught.value)


def test_an_earlier_calibration_is_where_the_next_begins():
    first = calibrated('all')
    again = calibrate([recording(TRUTH, seed) for seed in (10, 11)], values=first.values)
    assert again.before == {**first.values, 'arm': 'right'}
    assert (again.rms_before < 0.7 * first.rms_before).all()
    assert (again.rms_after < 1.1 * again.rms_before).all()
    assert max(map(abs, off(again, TRUTH).values())) < 3.0


def test_a_wrong_beginning_is_left_behind():
    wrong = {'effort_model.coulomb': (2.0,) * 3 + (0.4,) * 4, 'effort_model.dahl': (1.0,) * 7,
             'effort_model.bias': (1.0,) * 7, 'effort_model.dahl_length': 0.02,
             'effort_model.viscous': (0.5,) * 7}
    found = calibrate(recordings('all'), values=wrong)
    assert (found.rms_after < 1.1 * calibrated('all').rms_after).all()
    assert found.values['effort_model.dahl_length'] == 0.02
    for name in ('coulomb', 'dahl', 'viscous'):
        np.testing.assert_allclose(found.values[f'effort_model.{name}'],
                                   TRUTH[f'effort_model.{name}'], atol=0.2, err_msg=name)


def test_only_fits_what_is_named_and_nothing_else():
    found = calibrate(recordings('friction')[:2], only=('coulomb',))
    assert [step.term for step in found.steps] == ['', 'coulomb']
    assert found.steps[1].joints == tuple(range(7))
    changed = {name for name, value in found.values.items() if value != found.before[name]}
    assert changed == {'effort_model.coulomb'}


def test_only_refuses_a_name_that_is_none_and_lists_those_that_are():
    with pytest.raises(ArgumentError, match='no term colomb; there are added_inertia, bias'):
        calibrate(recordings('friction')[:1], only=('colomb',))


def test_a_value_that_is_refused_is_named():
    with pytest.raises(ArgumentError, match='effort_model.coulomb'):
        calibrate(recordings('friction')[:1], values={'effort_model.coulomb': [-1.0] * 7})


def test_the_same_data_give_the_same_answer():
    first, second = (calibrate(recordings('friction')[:2]) for _ in range(2))
    assert first.values == second.values
    assert first.warnings == second.warnings
    np.testing.assert_array_equal([p.uncertainty for p in first.parameters],
                                  [p.uncertainty for p in second.parameters])


def test_it_says_what_it_does():
    said = []
    calibrate(recordings('friction')[:1], only=('bias',), progress=said.append)
    assert said[0] == 'reading motion 0'
    assert said[-2:] == ['fitting', 'judging on what was left out']


@lru_cache
def heavy():
    """Return the settings of a robot with links of its own, friction, and a tilted base."""
    values = dict(PredictorSettings({**FRICTION, 'gravity': TRUTH['gravity']}).values)
    links = Links(PredictorSettings(values).arm)
    links.update(values, np.random.default_rng(4).normal(0.0, 0.05, 70))
    return values


def test_links_of_its_own_are_found_as_far_as_the_motion_shows_them():
    """Few of the 70 numbers show alone; what must hold is the prediction, and 3 sigma."""
    data = [recording(heavy(), seed) for seed in range(3)]
    found = calibrate(data, inertial=True)
    errors = off(found, heavy())
    print({name: round(error, 1) for name, error in errors.items()})
    assert max(map(abs, errors.values())) < 3.0
    assert (found.rms_after < 1.3 * EFFORT_NOISE + 0.05).all()
    assert len([p for p in found.parameters if p.term == 'inertial']) == 28
    without = calibrate(data)
    assert (found.rms_after < without.rms_after)[:4].all()
    other = recording(heavy(), 9, 20.0)
    left = residual(observe(other, found.values), found.values)
    assert (np.sqrt(np.mean(left ** 2, axis=0)) < 1.3 * EFFORT_NOISE + 0.05).all()


def test_a_payload_is_found():
    truth = {**TRUTH, 'payload.mass': 1.0, 'payload.center_of_mass': (0.03, -0.04, 0.08)}
    found = calibrate([recording(truth, seed) for seed in range(2)], payload=True)
    assert found.values['payload.mass'] == pytest.approx(1.0, rel=0.02)
    np.testing.assert_allclose(found.values['payload.center_of_mass'], (0.03, -0.04, 0.08),
                               atol=0.01)
    errors = off(found, truth)
    print({name: round(error, 1) for name, error in errors.items()})
    assert max(map(abs, errors.values())) < 3.0
    friction = kept(found)
    for name in ('coulomb', 'dahl'):  # a load that is not known yet does not hide it
        for joint, value in zip(JOINTS, TRUTH[f'effort_model.{name}']):
            assert value == 0.0 or joint in friction[name], (name, joint)


def test_a_payload_that_is_not_there_weighs_nothing():
    found = calibrate(recordings('friction')[:2], payload=True)
    (mass,) = [p for p in found.parameters if p.name == 'payload mass']
    assert 0.0 <= mass.after < 3 * mass.uncertainty
    assert mass.uncertainty < 0.05


def test_bodies_stay_possible_whatever_the_data_say():
    """Effort of the wrong sign asks for links of negative mass."""
    def upside_down(position, velocity, effort):
        return position, velocity, -effort
    found = calibrate([recording(FRICTION, 0, 20.0).changed(upside_down)], inertial=True,
                      payload=True)
    arm = PredictorSettings(found.values).arm  # is not refused
    assert np.linalg.eigvalsh(arm.parameters.pseudo_inertia).min() > 0.0
    assert found.values['payload.mass'] >= 0.0

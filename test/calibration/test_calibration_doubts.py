"""Calibrations with doubtful data: what the motion does not show, refusals, lag, single terms."""

from baxter_dynamics_ros.estimation.settings import EffortModelSettings, PredictorSettings
from baxter_dynamics_ros.model.exceptions import ArgumentError
from baxter_dynamics_ros.model.joints import JOINTS
import numpy as np
import pytest

pytest.importorskip('scipy', reason='needs SciPy: pip install ".[offline]"')

from baxter_dynamics_ros.calibration.calibrate_robot import calibrate  # noqa: E402, I100
from baxter_dynamics_ros.calibration.checks import CalibrationError  # noqa: E402
from baxter_dynamics_ros.calibration.fit_data import observe  # noqa: E402

pytestmark = pytest.mark.filterwarnings('error')


def test_joints_that_do_not_reverse_are_named_and_keep_their_parameters(robot):
    """The joints s1 and w2 rest, w0 starts from rest and turns one way."""
    def motion(seed, t):
        q, qd, qdd = robot.wander(seed, t)
        q[:, (1, 6)] = robot.CENTER[[1, 6]]
        qd[:, (1, 6)] = qdd[:, (1, 6)] = 0.0
        start = 0.1 * (1.0 - np.exp(-t))
        q[:, 4], qd[:, 4], qdd[:, 4] = 0.1 * t - start - 1.0, start, 0.1 * np.exp(-t)
        return q, qd, qdd
    found = calibrate([robot.recording(robot.FRICTION, seed, 12.0, motion=motion)
                       for seed in range(2)])
    assert 's1, w2: never moves faster than 0.05 rad/s' in found.warnings
    assert 'w0: turns one way only' in found.warnings
    for joint in (1, 4, 6):
        (line,) = [line for line in found.warnings if line.startswith(
            f'{JOINTS[joint]}: the motion does not show')]
        for term in ('coulomb', 'viscous', 'dahl', 'added_inertia', 'stiffness'):
            assert getattr(found.after.effort_model, term)[joint] == 0.0, term
            assert term in line or (joint, term) == (1, 'stiffness')
    np.testing.assert_allclose(np.array(found.after.effort_model.coulomb)[[0, 2, 3, 5]],
                               np.array(robot.FRICTION['effort_model.coulomb'])[[0, 2, 3, 5]],
                               atol=0.1)


@pytest.mark.parametrize('lag', [0.0, 0.03])
def test_velocity_lag_is_measured_and_adopted(robot, lag):
    found = calibrate([robot.recording(robot.FRICTION, seed, 12.0, lag) for seed in range(2)],
                      only=('bias', 'coulomb'))
    np.testing.assert_allclose([found.lag.value, *found.lag.per_joint], lag, atol=0.002)
    assert found.lag.uncertainty < 0.0005
    assert found.after.acceleration.velocity_lag == round(max(found.lag.value, 0.0), 4)
    assert found.before.acceleration.velocity_lag == found.after.acceleration.velocity_lag
    assert (found.rms_after < 1.2 * robot.LEAST).all()


def test_usual_velocity_lag_is_kept(robot):
    assert robot.calibrated('friction').lag.value == pytest.approx(0.014, abs=0.001)
    assert robot.calibrated('friction').after.acceleration.velocity_lag == 0.014


def test_no_lag_without_velocities(robot):
    found = calibrate([robot.recording(robot.FRICTION, 0, 12.0).changed(
        lambda position, velocity, effort: (position, np.empty(0), effort))], only=('bias',))
    assert found.lag is None
    assert found.after.acceleration.velocity_lag == 0.014
    assert [line for line in found.warnings if 'velocity_missing' in line]


def test_one_recording_is_split_by_time(robot):
    """Its laps may repeat, which a warning states."""
    found = calibrate(robot.recordings('friction')[:1], only=('bias', 'coulomb'))
    assert found.by_time
    assert [j.name for j in found.judged] == [f'motion 0, part {k}' for k in range(1, 6)]
    assert sum(j.duration for j in found.judged) == pytest.approx(29.8, abs=0.1)
    assert [line for line in found.warnings if line.startswith('one recording: judged on each of '
            '5 parts of it') and 'lap after lap' in line]
    assert max(map(abs, robot.off(found, robot.FRICTION).values())) < 3.0


def test_each_of_two_recordings_judges_the_other(robot):
    """An offset of 1 N m at e0 in one recording is the error of both fits."""
    one, other = robot.recordings('friction')
    empty = robot.recording(robot.FRICTION, 0, 1.0).part(0, 5)
    empty.name = 'nothing'
    found = calibrate([empty, one, other.changed(lambda position, velocity, effort: (
        position, velocity, effort + np.eye(7)[2]))], only=('bias', 'coulomb'))
    assert not found.by_time
    assert [judged.name for judged in found.judged] == ['motion 0', 'motion 1']
    assert 'nothing: 0.0 s of motion are too short: left out' in found.warnings
    for judged in found.judged:
        assert judged.after[2] == pytest.approx(1.0, abs=0.02)
        assert (judged.after < robot.LEAST)[[0, 1, 3, 4, 5, 6]].all()
    np.testing.assert_allclose([step.rms[2] for step in found.steps[1:]], [1.1, 1.0], atol=0.1)
    (bias,) = [p for p in found.of_term('bias') if p.joint == 2]
    assert bias.value == pytest.approx(0.9, abs=0.05)
    assert 0.3 < bias.deviation < 1.0


def tremble(robot):
    """Return a recording of joints that hardly move."""
    def motion(seed, t):
        angle = 3.0 * t[:, None] + np.arange(7)
        return (robot.CENTER + 0.01 * np.sin(angle), 0.03 * np.cos(angle), -0.09 * np.sin(angle))
    return robot.recording(robot.FRICTION, 0, 12.0, motion=motion)


def with_effort(robot, change):
    return robot.recording(robot.FRICTION, 0, 11.0).changed(
        lambda position, velocity, effort: (position, velocity, change(effort)))


def of_the_other_arm(robot):
    one = robot.recording({'arm': 'right'}, 0, 11.0)
    one.arm = 'left'
    return one


REFUSED = {
    'no recordings': lambda robot: [],
    'too short': lambda robot: [robot.recording(robot.FRICTION, 0, 9.0)],
    'no joint moves': lambda robot: [tremble(robot)],
    'measured effort is exactly zero': lambda robot: [with_effort(robot, np.zeros_like)],
    'no measured effort': lambda robot: [with_effort(robot, lambda effort: effort[:0])],
    'both arms': lambda robot: [robot.recording({'arm': side}, 0, 1.0)
                                for side in ('left', 'right')],
    'no valid joint states of the arm': lambda robot: [of_the_other_arm(robot)],
}


@pytest.mark.parametrize('reason', REFUSED)
def test_useless_recordings_are_refused_with_the_reason(robot, reason):
    with pytest.raises(CalibrationError, match=reason) as caught:
        calibrate(REFUSED[reason](robot))
    assert '\n' not in str(caught.value)


def test_duration_of_a_looping_bag_is_that_of_its_laps(robot):
    """The stamps jump back between the laps."""
    one = robot.recording(robot.FRICTION, 0, 11.0)
    one.states = one.states + one.states
    assert observe(one, PredictorSettings()).duration == pytest.approx(2 * 10.8, abs=0.1)
    found = calibrate([one], only=('bias',))
    assert [line for line in found.warnings if 'reset_clock_jump' in line]


def test_only_fits_the_named_terms_and_reports_the_stages(robot):
    stages = []
    found = calibrate(robot.recordings('friction'), only=('coulomb',), progress=stages.append)
    assert [step.term for step in found.steps] == ['', 'coulomb']
    assert found.steps[1].joints == tuple(range(7))
    changed = {name for name, value in found.after.parameters().items()
               if value != found.before.parameters()[name]}
    assert {name for name in changed if 'deviation' not in name} == {'effort_model.coulomb'}
    assert stages == ['reading motion 0', 'reading motion 1', 'fitting',
                      'judging on what was left out']


@pytest.mark.parametrize('arguments, message', [
    ({'only': ('colomb',)}, 'no term colomb; there are added_inertia, bias'),
    ({'settings': PredictorSettings(effort_model=EffortModelSettings(enabled=False))},
     'effort_model.enabled: false'),
    ({'settings': PredictorSettings(align=False)}, 'align: false')])
def test_unusable_arguments_are_refused_by_name(robot, arguments, message):
    with pytest.raises(ArgumentError, match=message):
        calibrate([robot.recording(robot.FRICTION, 0, 11.0)], **arguments)


def test_calibration_is_repeatable(robot):
    first, second = (calibrate(robot.recordings('friction')[:1]) for _ in range(2))
    assert first.after == second.after
    assert first.warnings == second.warnings
    assert first.parameters == second.parameters

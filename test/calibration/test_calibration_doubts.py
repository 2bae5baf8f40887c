"""What the data do not show is named, and what cannot be fitted to is refused; --only, and lag."""

from baxter_dynamics_ros.model.exceptions import ArgumentError
from baxter_dynamics_ros.model.joints import JOINTS
import numpy as np
import pytest

pytest.importorskip('scipy', reason='needs SciPy: pip install ".[offline]"')

from baxter_dynamics_ros.calibration.calibrate_robot import calibrate  # noqa: E402, I100
from baxter_dynamics_ros.calibration.checks import CalibrationError  # noqa: E402
from baxter_dynamics_ros.calibration.fit_data import observe  # noqa: E402

pytestmark = pytest.mark.filterwarnings('error')


@pytest.mark.parametrize('held', [(4,), (1, 6)], ids=['w0', 's1, w2'])
def test_joints_that_do_not_move_are_named_and_keep_what_they_had(robot, held):
    def motion(seed, t):
        q, qd, qdd = robot.wander(seed, t)
        q[:, held] = robot.CENTER[list(held)]
        qd[:, held] = qdd[:, held] = 0.0
        return q, qd, qdd
    found = calibrate([robot.recording(robot.FRICTION, seed, 20.0, motion=motion)
                       for seed in range(2)])
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
                               np.array(robot.FRICTION['effort_model.coulomb'])[others], atol=0.1)


def test_a_joint_that_turns_one_way_does_not_show_its_friction(robot):
    def motion(seed, t):
        q, qd, qdd = robot.wander(seed, t)
        start = 0.1 * (1.0 - np.exp(-t))  # it starts from rest, and goes on
        q[:, 4], qd[:, 4], qdd[:, 4] = 0.1 * t - start - 1.0, start, 0.1 * np.exp(-t)
        return q, qd, qdd
    found = calibrate([robot.recording(robot.FRICTION, seed, 20.0, motion=motion)
                       for seed in range(2)])
    assert 'w0: turns one way only' in found.warnings
    (line,) = [line for line in found.warnings if line.startswith('w0: the motion does not show')]
    assert 'coulomb' in line and 'dahl' in line, line
    assert found.values['effort_model.coulomb'][4] == found.values['effort_model.dahl'][4] == 0.0


@pytest.mark.parametrize('lag, taken', [(0.0, True), (0.014, False), (0.03, True)])
def test_the_velocitys_lag_is_measured_and_taken_over(robot, lag, taken):
    found = calibrate([robot.recording(robot.FRICTION, seed, 20.0, lag) for seed in range(2)])
    assert found.lag.value == pytest.approx(lag, abs=0.001)
    np.testing.assert_allclose(found.lag.per_joint, lag, atol=0.002)
    assert found.lag.uncertainty < 0.0005
    value = found.values['acceleration.velocity_lag']
    assert value == found.before['acceleration.velocity_lag']
    assert value == (pytest.approx(lag, abs=0.001) if taken else 0.014)
    assert (found.rms_after < 1.2 * robot.LEAST).all()


def test_without_velocities_there_is_no_lag(robot):
    def blind(position, velocity, effort):
        return position, np.empty(0), effort
    found = calibrate([robot.recording(robot.FRICTION, 0, 20.0).changed(blind)])
    assert found.lag is None
    assert found.values['acceleration.velocity_lag'] == 0.014
    assert [line for line in found.warnings if 'velocity_missing' in line]


def test_one_recording_is_split_by_time_and_says_that_laps_repeat(robot):
    found = calibrate(robot.recordings('friction')[:1])
    assert found.by_time
    assert [j.name for j in found.judged] == [f'motion 0, part {k}' for k in range(1, 6)]
    assert sum(j.duration for j in found.judged) == pytest.approx(29.8, abs=0.1)
    assert [line for line in found.warnings if line.startswith('one recording: judged on each of '
            '5 parts of it') and 'lap after lap' in line]
    assert max(map(abs, robot.off(found, robot.FRICTION).values())) < 3.0


def test_two_recordings_judge_each_other(robot):
    """Robots that differ by 1 N m at e0: each is off by all of it with what the other gives."""
    def offset(position, velocity, effort):
        return position, velocity, effort + np.eye(7)[2]
    one, other = robot.recordings('friction')
    found = calibrate([one, other.changed(offset)], only=('bias', 'coulomb'))
    assert not found.by_time
    assert not [line for line in found.warnings if 'lap' in line]
    assert [judged.name for judged in found.judged] == ['motion 0', 'motion 1']
    for judged in found.judged:
        assert judged.after[2] == pytest.approx(1.0, abs=0.02)
        assert (judged.after < robot.LEAST)[[0, 1, 3, 4, 5, 6]].all()
    np.testing.assert_allclose([step.rms[2] for step in found.steps[1:]], [1.1, 1.0], atol=0.1)
    assert found.values['effort_model.bias'][2] == pytest.approx(0.9, abs=0.05)
    (bias,) = [p for p in found.of_term('bias') if p.joint == 2]
    assert 0.3 < bias.deviation < 1.0  # they say so


def test_a_recording_without_the_arm_does_not_stop_the_others(robot):
    empty = robot.recording(robot.FRICTION, 0, 1.0).part(0, 5)
    empty.name = 'nothing'
    found = calibrate([empty, *robot.recordings('friction')], only=('bias', 'coulomb'))
    assert [j.name for j in found.judged] == ['motion 0', 'motion 1']
    assert 'nothing: 0.0 s of motion are too short: left out' in found.warnings


def tremble(robot):
    """Return a recording of joints that hardly move."""
    def motion(seed, t):
        q, qd, qdd = robot.wander(seed, t)
        return robot.CENTER + 0.01 * (q - robot.CENTER), 0.01 * qd, 0.01 * qdd
    return robot.recording(robot.FRICTION, 0, 15.0, motion=motion)


def with_effort(robot, change):
    """Return a recording with another effort."""
    return robot.recording(robot.FRICTION, 0, 12.0).changed(
        lambda position, velocity, effort: (position, velocity, change(effort)))


def of_the_other_arm(robot):
    """Return a recording that says it is of the arm that it is not of."""
    one = robot.recording({'arm': 'right'}, 0, 12.0)
    one.arm = 'left'
    return one


REFUSED = {
    'no recordings': lambda robot: [],
    'too short': lambda robot: [robot.recording(robot.FRICTION, 0, 9.0)],
    'no joint moves': lambda robot: [tremble(robot)],
    'measured effort is exactly zero': lambda robot: [with_effort(robot, np.zeros_like)],
    'no measured effort': lambda robot: [with_effort(robot, lambda effort: effort[:0])],
    'both arms': lambda robot: [robot.recording({'arm': side}, 0, 12.0)
                                for side in ('left', 'right')],
    'no valid joint states of the arm': lambda robot: [of_the_other_arm(robot)],
}


@pytest.mark.parametrize('reason', REFUSED)
def test_what_cannot_be_fitted_to_is_refused_with_the_reason(robot, reason):
    given = REFUSED[reason](robot)
    with pytest.raises(CalibrationError, match=reason) as caught:
        calibrate(given)
    assert '\n' not in str(caught.value)


def test_a_bag_that_loops_is_as_long_as_its_laps(robot):
    """Its stamps jump back: from the first to the last there is no time at all."""
    one = robot.recording(robot.FRICTION, 0, 12.0)
    one.states = one.states + one.states
    assert observe(one, {}).duration == pytest.approx(2 * 11.8, abs=0.1)
    found = calibrate([one], only=('bias',))
    assert [line for line in found.warnings if 'reset_clock_jump' in line]


def test_only_fits_what_is_named_and_nothing_else(robot):
    found = calibrate(robot.recordings('friction'), only=('coulomb',))
    assert [step.term for step in found.steps] == ['', 'coulomb']
    assert found.steps[1].joints == tuple(range(7))
    changed = {name for name, value in found.values.items() if value != found.before[name]}
    assert changed == {'effort_model.coulomb'}


def test_only_refuses_a_name_that_is_none_and_lists_those_that_are(robot):
    with pytest.raises(ArgumentError, match='no term colomb; there are added_inertia, bias'):
        calibrate(robot.recordings('friction')[:1], only=('colomb',))


def test_a_value_that_is_refused_is_named(robot):
    with pytest.raises(ArgumentError, match='effort_model.coulomb'):
        calibrate(robot.recordings('friction')[:1], values={'effort_model.coulomb': [-1.0] * 7})


@pytest.mark.parametrize('name', ['effort_model.enabled', 'align'])
def test_what_would_make_a_fit_useless_is_refused(robot, name):
    with pytest.raises(ArgumentError, match=f'{name}: false'):
        calibrate(robot.recordings('friction')[:1], values={name: False})


def test_the_same_data_give_the_same_answer(robot):
    first, second = robot.calibrated('friction'), calibrate(robot.recordings('friction'))
    assert first.values == second.values
    assert first.warnings == second.warnings
    np.testing.assert_array_equal([p.deviation for p in first.parameters],
                                  [p.deviation for p in second.parameters])


def test_it_says_what_it_does(robot):
    said = []
    calibrate(robot.recordings('friction')[:1], only=('bias',), progress=said.append)
    assert said[0] == 'reading motion 0'
    assert said[-2:] == ['fitting', 'judging on what was left out']

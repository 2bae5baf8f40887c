"""The node on a stream: what it publishes is what the stream handler computes, and is right."""

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
from perfect_robot import measured
import pytest


def synthetic(sine, seconds=2.0, period=0.01):
    """Return rows (q, qd, effort) of a robot whose velocity lags and whose effort is exact."""
    t = np.arange(0.0, seconds, period)
    return t, list(zip(*measured(PredictorSettings(), t, sine)))


@pytest.mark.parametrize('check_fields', ['', '1'], ids=['plain', 'ROS_PYTHON_CHECK_FIELDS'])
@pytest.mark.parametrize('side', ['right', 'left'])
def test_publishes_what_the_handler_computes(robot, start_predictor, sine, stamps, side,
                                             check_fields):
    start_predictor('-p', f'arm:={side}', ROS_PYTHON_CHECK_FIELDS=check_fields)
    _, rows = synthetic(sine)
    offline = Predictor(PredictorSettings(arm=side))
    expected = [offline.handle(10 ** 18 + k * 10_000_000, joint_names(side), *row).prediction
                for k, row in enumerate(rows)]
    expected = {p.stamp_ns: p for p in expected if p is not None}

    robot.stream(rows, side=side)
    robot.until(lambda: len(robot.residual) >= len(expected))

    assert stamps(robot.predicted) == stamps(robot.residual) == sorted(expected)
    for predicted, residual, stamp in zip(robot.predicted, robot.residual, sorted(expected)):
        assert tuple(predicted.name) == tuple(residual.name) == joint_names(side)
        np.testing.assert_array_equal(predicted.position, expected[stamp].q)
        np.testing.assert_array_equal(predicted.velocity, expected[stamp].qd)
        np.testing.assert_array_equal(predicted.effort, expected[stamp].effort)
        np.testing.assert_array_equal(residual.effort, expected[stamp].residual)


def test_stamp_is_the_instant_the_prediction_is_for(robot, predictor, sine, stamps):
    t, rows = synthetic(sine, seconds=3.0)
    robot.stream(rows)
    robot.until(lambda: len(robot.predicted) >= len(rows) - 21)
    when = (np.array(stamps(robot.predicted)) - 10 ** 18) * 1e-9
    assert t[-1] - when[-1] == pytest.approx(0.014 + np.sqrt(2) / (2 * np.pi * 5), abs=1e-6)
    q = sine(when)[0]
    np.testing.assert_allclose([m.position for m in robot.predicted], q, atol=1e-3)
    assert np.abs([m.effort for m in robot.residual][-100:]).max() < 0.15


def test_residual_is_measured_less_predicted(robot, predictor, sine):
    _, rows = synthetic(sine)
    extra = np.array([1.0, -2.0, 3.0, -4.0, 0.5, -0.6, 0.7])
    robot.stream([(q, qd, effort + extra) for q, qd, effort in rows])
    robot.until(lambda: len(robot.residual) == len(rows) - 21)
    np.testing.assert_allclose(np.mean([m.effort for m in robot.residual], axis=0), extra,
                               atol=0.1)


def test_other_messages_on_the_topic_do_no_harm(robot, predictor, sine):
    _, rows = synthetic(sine)
    nan = [np.nan] * 7
    names = joint_names('right')
    for k, row in enumerate(rows):
        stamp = 10 ** 18 + k * 10_000_000
        robot.send(stamp, ['r_gripper_l_finger_joint'], [0.0], [0.0], [0.0])
        robot.send(stamp, names, nan, row[1], row[2])
        robot.send(stamp, names, row[0], np.full(7, np.inf), row[2])
        robot.send(stamp, names[:6], row[0][:6], row[1][:6], row[2][:6])
        robot.send(stamp, names, row[0][:5])
        robot.send(stamp, [], [])
        robot.send_arm(stamp, *row)
        robot.spin(0.01)
    robot.until(lambda: len(robot.residual) >= len(rows) - 21)
    for message in robot.predicted + robot.residual:
        assert np.isfinite([*message.position, *message.velocity, *message.effort]).all()
    assert len(robot.predicted) == len(rows) - 21
    counts = robot.report()['input'][2]
    n = len(rows)
    assert int(counts['not_this_arm']) == 2 * n
    assert int(counts['non_finite']) == 2 * n
    assert int(counts['incomplete_arm']) == n
    assert int(counts['length_mismatch']) == n
    assert int(counts['received']) == 7 * n


def test_without_valid_effort_there_is_a_prediction_and_no_residual(robot, predictor, sine):
    _, rows = synthetic(sine, seconds=1.5)
    robot.stream([(q, qd, None) for q, qd, _ in rows])
    robot.until(lambda: len(robot.predicted) > 100)
    robot.stream([(q, qd, None) for q, qd, _ in rows[:1]], start=10 ** 18 + 10 ** 10)
    for k, (q, qd, _) in enumerate(rows):
        names = joint_names('right')
        robot.send(10 ** 18 + 2 * 10 ** 10 + k * 10_000_000, names, q, qd, np.zeros(7))
        robot.spin(0.01)
    robot.until(lambda: len(robot.predicted) > 220)
    assert robot.residual == []
    level, message, values = robot.report()['effort']
    assert int(values['effort_missing']) == len(rows)  # without the stray one, 10 s ahead
    assert int(values['effort_all_zero']) == len(rows)


def test_without_velocity_the_positions_serve(robot, predictor, sine, stamps):
    t, rows = synthetic(sine, seconds=2.5)
    robot.stream([(q, None, effort) for q, _, effort in rows])
    robot.until(lambda: len(robot.residual) == len(rows) - 21)
    assert np.abs([m.effort for m in robot.residual][-100:]).max() < 0.15
    delay = 10 ** 18 + t[-1] * 1e9 - stamps(robot.predicted)[-1]
    assert delay * 1e-9 == pytest.approx(0.015 + np.sqrt(2) / (2 * np.pi * 5), abs=1e-6)


def test_a_gap_and_a_reset_make_the_filter_settle_anew(robot, predictor, sine, stamps):
    from std_srvs.srv import Trigger
    _, rows = synthetic(sine, seconds=1.0)
    robot.stream(rows, start=10 ** 18)
    robot.until(lambda: len(robot.predicted) == len(rows) - 21)
    robot.stream(rows, start=10 ** 18 + 2 * 10 ** 9)
    robot.until(lambda: len(robot.predicted) == 2 * (len(rows) - 21) - 1)  # one to confirm
    answer = robot.call(Trigger, 'reset')
    assert answer.success
    robot.stream(rows, start=10 ** 18 + 3 * 10 ** 9)
    robot.until(lambda: len(robot.predicted) == 3 * (len(rows) - 21) - 1)
    values = robot.report()['filter'][2]
    assert values['reset_gap'] == '1'
    assert values['reset_requested'] == '1'


def test_diagnostics_say_that_nothing_arrives_and_what_to_do(robot, predictor):
    level, message, values = robot.report()['input']
    assert level == b'\x03'  # STALE
    assert message == 'no joint states received on /robot/joint_states; publishers: 1'
    assert values['rate [Hz]'] == '0.0'


def test_diagnostics_of_a_healthy_stream(robot, predictor, sine):
    _, rows = synthetic(sine, seconds=5.0)
    robot.stream(rows)
    reports = [m for m in robot.diagnostics if m.status[0].name == 'torque_predictor: input']
    status = {s.name: s for s in reports[-1].status}
    values = {name: {pair.key: pair.value for pair in s.values} for name, s in status.items()}
    assert all(s.level == b'\x00' for s in status.values())
    assert all(s.hardware_id == 'baxter_right_arm' for s in status.values())
    assert float(values['torque_predictor: input']['rate [Hz]']) > 0.0
    assert float(values['torque_predictor: input']['age [s]']) < 1.0
    assert values['torque_predictor: filter']['state'] == 'running'
    assert values['torque_predictor: effort']['valid'] == 'True'
    assert float(values['torque_predictor: residual']['s1 RMS [N m]']) < 0.15


@pytest.mark.parametrize('spoil, reason', [
    (lambda row: (np.degrees(row[0]), row[1], row[2]), 'units are rad, rad/s and N m'),
    (lambda row: (row[0] * np.nan, row[1], row[2]), 'NaN positions'),
], ids=['degrees', 'NaN'])
def test_diagnostics_name_what_is_wrong_with_all_messages(robot, predictor, sine, spoil, reason):
    _, rows = synthetic(sine, seconds=3.0)
    robot.stream([spoil(row) for row in rows])
    status = {s.name: s for s in robot.diagnostics[-1].status}
    assert status['torque_predictor: input'].level == b'\x02'  # ERROR
    assert reason in status['torque_predictor: input'].message
    assert status['torque_predictor: effort'].level == b'\x03'  # STALE
    assert 'valid' not in status['torque_predictor: effort'].message
    assert reason in predictor.output

"""The node on a stream: it publishes and reports the results of the stream handler."""

import os

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names, SIDES
from baxter_dynamics_ros.nodes.step_statistics import MessageLoss, StepStatistics
import numpy as np
import perfect_robot
import pytest
from robot_node import LOSSLESS
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger

START = 10 ** 18
OK, ERROR, STALE = b'\x00', b'\x02', b'\x03'
DELAY = 0.014 + np.sqrt(2) / (2 * np.pi * 5)  # [s]
EXTRA = np.array([1.0, -2.0, 3.0, -4.0, 0.5, -0.6, 0.7])  # [N m]
ROWS = perfect_robot.rows(np.arange(0.0, 4.0, 0.01))


def counts(robot, since=None):
    """Return the counts of the filter's status, less earlier ones."""
    values = robot.report()['filter'][2]
    return {key: int(value) - (since[key] if since else 0) for key, value in values.items()
            if key.startswith('reset')}


def test_missing_and_useless_input_is_one_warning_with_the_cause(robot, predictor):
    level, message, values = robot.report()['input']
    assert level == STALE
    assert message == 'no joint states received on /robot/joint_states; publishers: 1'
    assert values['rate [Hz]'] == '0.0'
    assert predictor.output.count('[WARN]') == 1, predictor.output

    for spoil, reason in ((np.degrees, 'units are rad, rad/s and N m'),
                          (lambda q: q * np.nan, 'NaN positions')):
        report = robot.move_until_report(lambda report: reason in report['input'][1],
                                         [(spoil(q), *rest) for q, *rest in ROWS])
        assert report['input'][0] == ERROR
        assert report['effort'][0] == STALE and 'valid' not in report['effort'][1]
        assert reason in predictor.output


def test_other_names_are_reported(robot, predictor):
    for names, words in (
            (['base/right_s0', 'grip\x1b[31m'], ['base/right_s0', 'grip\\x1b', 'joint_prefix']),
            ([], ['contain no joint names'])):
        robot.until(lambda: robot.send(START, names, np.zeros(len(names))) or any(
            report['input'][0] == STALE and 'right_s0 ... right_w2' in report['input'][1]
            and all(word in report['input'][1] for word in words)
            for report in robot.statuses()))
    assert '\x1b' not in predictor.output


def test_publishes_residuals_of_a_moving_arm_and_finds_nothing_wrong(robot, predictor, stamps):
    rows = [(q, qd, effort + EXTRA) for q, qd, effort in ROWS]
    last = robot.stream(rows)
    robot.until(lambda: len(robot.residual) == len(rows) - 21 == len(robot.predicted))
    assert stamps(robot.predicted) == stamps(robot.residual)
    assert (last - stamps(robot.residual)[-1]) * 1e-9 == pytest.approx(DELAY, abs=1e-6)
    residual = np.array([m.effort for m in robot.residual][-100:])
    assert np.abs(residual - EXTRA).max() < 0.15  # measured minus predicted

    report = robot.move_until_report(lambda report: {
        status[0] for status in report.values()} == {OK}, rows, last + 10_000_000)
    assert report['filter'][2]['state'] == 'running'
    assert report['effort'][2]['valid'] == 'True'
    for message in robot.diagnostics:
        assert {status.hardware_id for status in message.status} == {'baxter_right_arm'}


def test_filter_settles_after_a_gap_and_a_reset(robot, predictor):
    before, rows = counts(robot), ROWS[:60]
    settled = len(rows) - 21
    robot.stream(rows)
    robot.until(lambda: len(robot.predicted) == settled)
    robot.stream(rows, start=START + 2 * 10 ** 9)
    robot.until(lambda: len(robot.predicted) == 2 * settled - 1)  # one message confirms the gap
    assert robot.call(Trigger, 'reset').success
    robot.stream(rows, start=START + 3 * 10 ** 9)
    robot.until(lambda: len(robot.predicted) == 3 * settled - 1)
    assert {key: n for key, n in counts(robot, before).items() if n} == {
        'reset_gap': 1, 'reset_requested': 1}


def test_nan_effort_of_gazebo_gives_predictions_and_no_residual(robot, predictor):
    """gz_ros2_control publishes Baxter's 17 joints in its own order, effort not available."""
    arm = joint_names('right')
    names = ['head_pan', *joint_names('left'), 'torso_t0', *arm[::-1], 'head_nod']
    contact = robot.listen(Bool, '/torque_predictor/contact')
    before = robot.report()
    q, qd, _ = perfect_robot.trajectory(np.arange(0.0, 1.0, 0.01))
    for k in range(len(q)):
        fields = [[row[k][arm.index(name)] if name in arm else np.nan for name in names]
                  for row in (q, qd)]
        robot.send(START + k * 10_000_000, names, *fields, [np.nan] * 17)
        robot.spin(0.015)  # diagnostics are due meanwhile
    robot.until(lambda: len(robot.predicted) == len(q) - 21)
    report = robot.report()
    assert not robot.residual and not contact
    missing, invalid = (int(report[name][2][key]) - int(before[name][2][key]) for name, key in (
        ('effort', 'effort_missing'), ('input', 'non_finite')))
    assert (missing, invalid) == (len(q), 0)
    assert predictor.output.count('no measured effort (empty or NaN)') == 1


def test_two_nodes_predict_two_arms_with_prefix_frame_and_payload(robot, start):
    load = {'right': 0.5, 'left': 1.2}  # [kg]
    for side in SIDES:
        start('torque_predictor', '-r', f'__ns:=/{side}', '-p', f'arm:={side}', '-p',
              f'payload.mass:={load[side]}', '-p', 'joint_prefix:=robot_1/', '-p',
              'frame_id:=robot_1/base', *LOSSLESS, ROS_PYTHON_CHECK_FIELDS='1')
    residuals = {side: robot.listen(JointState, f'/{side}/torque_predictor/effort_residual')
                 for side in SIDES}
    robot.until(lambda: robot.publisher.get_subscription_count() == 2 and all(
        robot.statuses(f'{side}/torque_predictor') for side in SIDES))
    names = [f'robot_1/{name}' for name in joint_names('right') + joint_names('left')]
    q, qd, _ = perfect_robot.trajectory(np.arange(60) * 0.01)
    rows = [(np.concatenate([q[k], -0.5 * q[k]]), np.concatenate([qd[k], -0.5 * qd[k]]),
             np.concatenate([q[k] + 1.0, q[k] - 1.0])) for k in range(60)]
    for k, row in enumerate(rows):
        robot.send(START + k * 10_000_000, names, *row)
    robot.until(lambda: all(len(residuals[side]) == 60 - 21 for side in SIDES))
    for side in SIDES:
        alone = Predictor(PredictorSettings.from_parameters(
            {'arm': side, 'payload.mass': load[side], 'joint_prefix': 'robot_1/'}))
        steps = [alone.handle(START + k * 10_000_000, names, *row) for k, row in enumerate(rows)]
        assert [list(m.effort) for m in residuals[side]] == [
            step.prediction.residual.tolist() for step in steps if step.prediction]
        for message in residuals[side]:
            assert list(message.name) == [f'robot_1/{name}' for name in joint_names(side)]
            assert message.header.frame_id == 'robot_1/base'


def test_lost_messages_another_type_and_missing_service_types_are_reported(robot, start, tmp_path):
    robot.create_publisher(String, '/text', 1)
    hidden = tmp_path / 'baxter_dynamics_interfaces'
    hidden.mkdir()
    (hidden / '__init__.py').write_text('raise ImportError("no such types")\n')
    start('torque_predictor', '-r', '__ns:=/other', '-r', '/robot/joint_states:=/text')
    process = start(
        'torque_predictor', '-p', 'qos_overrides./robot/joint_states.subscription.depth:=5',
        PYTHONPATH=os.pathsep.join([str(tmp_path), os.environ.get('PYTHONPATH', '')]))
    robot.wait_for_node()
    q, qd, _ = perfect_robot.trajectory(np.arange(0.0, 10.0, 0.01))
    robot.send_arm(START, q[0], qd[0], np.ones(7))
    # Losses before the first message cannot be known.
    robot.until(lambda: robot.report()['input'][2]['received'] == '1')
    for k in range(1, len(q)):  # faster than any node takes them
        robot.send_arm(START + k * 10_000_000, q[k], qd[k], np.ones(7))
    robot.spin(0.5)
    robot.send_arm(START + len(q) * 10_000_000, q[0], qd[0], np.ones(7))
    robot.until(lambda: sum(int(robot.statuses()[-1]['input'][2][key])
                            for key in ('received', 'lost')) == len(q) + 1)

    robot.until(lambda: 'published as std_msgs/msg/String' in str(
        [report['input'] for report in robot.statuses('other/torque_predictor')]))
    assert 'cannot be imported (no such types). Build it' in process.output
    services = [name for name, _ in robot.get_service_names_and_types()]
    assert '/torque_predictor/reset' in services
    assert '/torque_predictor/gravity_torques' not in services


@pytest.mark.parametrize('publishers, numbers, lost', [
    (1, [1, 2, 3, 4], 0), (1, [7, 8, 10, 11], 1), (1, [1, 2, 1, 2, 4], 1), (1, [None, None], 0),
    (2, [1, 1000, 2, 1001, 3, 1003, 4], 1), (2, [5, 900, 901, 6, 7, 902, 9], 1)])
def test_gaps_in_sequence_numbers(publishers, numbers, lost):
    loss = MessageLoss()
    loss.matched(publishers)
    for number in numbers:
        loss.received(number)
    assert loss.lost == lost


def test_a_stream_that_begins_or_stops_within_a_period_is_not_slow():
    statistics, highest = StepStatistics(), []
    for taken in (0, 5, 105, 110, 110):
        statistics.close({'taken': taken}, 1.0)
        highest.append(statistics.highest_rate)
    assert highest == [np.inf, np.inf, 100.0, 100.0, np.inf]

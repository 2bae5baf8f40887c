"""The node on a stream: it publishes and reports the results of the stream handler."""

import os

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names, SIDES
from baxter_dynamics_ros.nodes.statistics import MessageLoss
import numpy as np
from perfect_robot import measured
import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger

START = 10 ** 18
OK, ERROR, STALE = b'\x00', b'\x02', b'\x03'
DELAY = 0.014 + np.sqrt(2) / (2 * np.pi * 5)  # [s]
EXTRA = np.array([1.0, -2.0, 3.0, -4.0, 0.5, -0.6, 0.7])  # [N m]


def synthetic(sine, seconds=2.0, period=0.01):
    """Return rows (q, qd, effort) of a robot whose velocity lags and whose effort is exact."""
    t = np.arange(0.0, seconds, period)
    return t, list(zip(*measured(PredictorSettings(), t, sine)))


@pytest.mark.parametrize('side, check_fields', [('right', ''), ('left', '1')])
def test_publishes_results_of_the_stream_handler(
        robot, start_predictor, sine, stamps, side, check_fields):
    start_predictor('-p', f'arm:={side}', ROS_PYTHON_CHECK_FIELDS=check_fields)
    _, rows = synthetic(sine, 4.0)
    rows = [(q, qd, effort + EXTRA) for q, qd, effort in rows]
    offline = Predictor(PredictorSettings(arm=side))
    expected = [offline.handle(START + k * 10_000_000, joint_names(side), *row).prediction
                for k, row in enumerate(rows)]
    expected = {p.stamp_ns: p for p in expected if p is not None}

    last = robot.stream(rows, side=side)
    robot.until(lambda: len(robot.residual) >= len(expected))

    assert stamps(robot.predicted) == stamps(robot.residual) == sorted(expected)
    assert (last - stamps(robot.residual)[-1]) * 1e-9 == pytest.approx(DELAY, abs=1e-6)
    for predicted, residual, stamp in zip(robot.predicted, robot.residual, sorted(expected)):
        assert tuple(predicted.name) == tuple(residual.name) == joint_names(side)
        np.testing.assert_array_equal(predicted.position, expected[stamp].q)
        np.testing.assert_array_equal(predicted.velocity, expected[stamp].qd)
        np.testing.assert_array_equal(predicted.effort, expected[stamp].effort)
        np.testing.assert_array_equal(residual.effort, expected[stamp].residual)
    residual = np.array([m.effort for m in robot.residual][-100:])
    assert np.abs(residual - EXTRA).max() < 0.15  # measured minus predicted

    if side == 'left':
        return
    report = robot.statuses()[-1]
    assert [status[:2] for status in report.values() if status[0] != OK] == []
    assert report['filter'][2]['state'] == 'running'
    assert report['effort'][2]['valid'] == 'True'
    for message in robot.diagnostics:
        assert {status.hardware_id for status in message.status} == {'baxter_right_arm'}


def test_two_nodes_predict_two_arms_with_their_parameters(robot, start, sine):
    load = {'right': 0.5, 'left': 1.2}  # [kg]
    for side in SIDES:
        start('torque_predictor', '-r', f'__ns:=/{side}', '-p', f'arm:={side}', '-p',
              f'payload.mass:={load[side]}', '-p',
              'qos_overrides./robot/joint_states.subscription.reliability:=reliable')
    residuals = {side: robot.listen(JointState, f'/{side}/torque_predictor/effort_residual')
                 for side in SIDES}
    robot.until(lambda: robot.publisher.get_subscription_count() == 2)
    robot.spin(0.5)
    names = joint_names('right') + joint_names('left')
    q, qd, _ = sine(np.arange(60) * 0.01)
    rows = [(np.concatenate([q[k], -0.5 * q[k]]), np.concatenate([qd[k], -0.5 * qd[k]]),
             np.concatenate([q[k] + 1.0, q[k] - 1.0])) for k in range(60)]
    for k, row in enumerate(rows):
        robot.send(START + k * 10_000_000, names, *row)
    robot.until(lambda: all(len(residuals[side]) == 60 - 21 for side in SIDES))
    for side in SIDES:
        alone = Predictor(PredictorSettings.from_parameters(
            {'arm': side, 'payload.mass': load[side]}))
        steps = [alone.handle(START + k * 10_000_000, names, *row) for k, row in enumerate(rows)]
        assert [list(m.effort) for m in residuals[side]] == [
            step.prediction.residual.tolist() for step in steps if step.prediction]
        assert all(tuple(m.name) == joint_names(side) for m in residuals[side])


def test_filter_settles_after_a_gap_and_a_reset(robot, predictor, sine):
    _, rows = synthetic(sine, seconds=0.6)
    settled = len(rows) - 21
    robot.stream(rows)
    robot.until(lambda: len(robot.predicted) == settled)
    robot.stream(rows, start=START + 2 * 10 ** 9)
    robot.until(lambda: len(robot.predicted) == 2 * settled - 1)  # one message confirms the gap
    assert robot.call(Trigger, 'reset').success
    robot.stream(rows, start=START + 3 * 10 ** 9)
    robot.until(lambda: len(robot.predicted) == 3 * settled - 1)
    values = robot.report()['filter'][2]
    assert values['reset_gap'] == values['reset_requested'] == '1'


def test_missing_and_useless_input_is_one_warning_with_the_cause(robot, predictor, sine):
    level, message, values = robot.report()['input']
    assert level == STALE
    assert message == 'no joint states received on /robot/joint_states; publishers: 1'
    assert values['rate [Hz]'] == '0.0'
    robot.spin(1.2)
    assert predictor.output.count('[WARN]') == 1, predictor.output

    _, rows = synthetic(sine, seconds=4.0)
    for spoil, reason in ((np.degrees, 'units are rad, rad/s and N m'),
                          (lambda q: q * np.nan, 'NaN positions')):
        robot.diagnostics.clear()
        robot.stream([(spoil(q), *rest) for q, *rest in rows], pace=0.006)
        report = robot.statuses()[-1]
        assert report['input'][0] == ERROR and reason in report['input'][1]
        assert report['effort'][0] == STALE and 'valid' not in report['effort'][1]
        assert reason in predictor.output


def test_other_names_are_reported(robot, predictor):
    for names, words in (
            (['base/right_s0', 'grip\x1b[31m'], ['base/right_s0', 'grip\\x1b', 'joint_prefix']),
            ([], ['have no joint names'])):
        robot.until(lambda: robot.send(START, names, np.zeros(len(names))) or any(
            report['input'][0] == STALE and 'right_s0 ... right_w2' in report['input'][1]
            and all(word in report['input'][1] for word in words)
            for report in robot.statuses()))
    assert '\x1b' not in predictor.output


def test_nan_effort_of_gazebo_gives_predictions_and_no_residual(robot, predictor, sine):
    """gz_ros2_control publishes Baxter's 17 joints in its own order, effort not available."""
    arm = joint_names('right')
    names = ['head_pan', *joint_names('left'), 'torso_t0', *arm[::-1], 'head_nod']
    contact = []
    robot.create_subscription(Bool, '/torque_predictor/contact', contact.append, 10)
    q, qd, _ = sine(np.arange(0.0, 1.0, 0.01))
    for k in range(len(q)):
        fields = [[row[k][arm.index(name)] if name in arm else np.nan for name in names]
                  for row in (q, qd)]
        robot.send(START + k * 10_000_000, names, *fields, [np.nan] * 17)
        robot.spin(0.004)
    robot.until(lambda: len(robot.predicted) == len(q) - 21)
    report = robot.report()
    assert not robot.residual and not contact
    assert int(report['effort'][2]['effort_missing']) == len(q)
    assert report['input'][2]['non_finite'] == '0'
    assert predictor.output.count('no measured effort (empty or NaN)') == 1


def test_prefix_and_frame(robot, start_predictor, sine):
    start_predictor('-p', 'joint_prefix:=robot_1/', '-p', 'frame_id:=robot_1/base')
    names = ['robot_1/' + name for name in joint_names('right')]
    q, qd, _ = sine(np.arange(0.0, 0.5, 0.01))
    for k in range(len(q)):
        robot.send(START + k * 10_000_000, names, q[k], qd[k])
        robot.spin(0.004)
    robot.until(lambda: len(robot.predicted) == len(q) - 21)
    assert list(robot.predicted[0].name) == names
    assert robot.predicted[0].header.frame_id == 'robot_1/base'


def test_another_type_is_reported_and_topics_can_be_remapped(robot, start):
    robot.create_publisher(String, '/text', 1)
    publisher = robot.create_publisher(JointState, '/sim/joint_states', 10)
    start('torque_predictor', '-r', '/robot/joint_states:=/text')
    start('torque_predictor', '-r', '/robot/joint_states:=/sim/joint_states')
    robot.until(lambda: publisher.get_subscription_count() == 1)
    robot.until(lambda: any('published as std_msgs/msg/String' in report['input'][1]
                            for report in robot.statuses()))


def test_messages_lost_by_the_middleware_are_counted(robot, start_predictor, sine):
    start_predictor('-p', 'qos_overrides./robot/joint_states.subscription.depth:=5')
    q, qd, _ = sine(np.arange(0.0, 10.0, 0.01))
    robot.send_arm(START, q[0], qd[0], np.ones(7))
    # Losses before the first message cannot be known.
    robot.until(lambda: robot.report()['input'][2]['received'] == '1')
    for k in range(1, len(q)):  # faster than any node takes them
        robot.send_arm(START + k * 10_000_000, q[k], qd[k], np.ones(7))
    robot.spin(0.5)
    robot.send_arm(START + len(q) * 10_000_000, q[0], qd[0], np.ones(7))
    values = robot.report()['input'][2]
    assert int(values['received']) + int(values['lost']) == len(q) + 1


@pytest.mark.parametrize('publishers, numbers, lost', [
    (1, [1, 2, 3, 4], 0), (1, [7, 8, 10, 11], 1), (1, [1, 2, 1, 2, 4], 1), (1, [None, None], 0),
    (2, [1, 1000, 2, 1001, 3, 1003, 4], 1), (2, [5, 900, 901, 6, 7, 902, 9], 1)])
def test_gaps_in_sequence_numbers(publishers, numbers, lost):
    loss = MessageLoss()
    loss.matched(publishers)
    for number in numbers:
        loss.received(number)
    assert loss.lost == lost


def test_topics_work_without_the_service_types(robot, start, tmp_path, sine):
    hidden = tmp_path / 'baxter_dynamics_interfaces'
    hidden.mkdir()
    (hidden / '__init__.py').write_text('raise ImportError("not installed")\n')
    path = os.pathsep.join([str(tmp_path), os.environ.get('PYTHONPATH', '')])
    process = start('torque_predictor', PYTHONPATH=path)
    robot.wait_for_node()
    robot.stream(synthetic(sine, 0.6)[1])
    robot.until(lambda: robot.residual)
    assert 'pip install ./baxter_dynamics_interfaces' in process.output
    services = [name for name, _ in robot.get_service_names_and_types()]
    assert '/torque_predictor/reset' in services
    assert '/torque_predictor/gravity_torques' not in services

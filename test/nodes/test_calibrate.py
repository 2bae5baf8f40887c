"""Action calibrate, live over DDS: recordings of a real arm are played to the node."""

import time
from types import SimpleNamespace

from action_msgs.msg import GoalStatus
from baxter_dynamics_ros.calibration import live
from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
from baxter_dynamics_ros.nodes import calibrate_action
from baxter_dynamics_ros.nodes.calibrate_action import CalibrateAction
from baxter_dynamics_ros.nodes.messages import joint_state, set_stamp, stamp_ns, to_field
from baxter_dynamics_ros.nodes.ros_parameters import ParameterNode
from baxter_dynamics_ros.nodes.step_statistics import StepStatistics
import numpy as np
import pytest
from rclpy.action import ActionClient

action = pytest.importorskip('baxter_dynamics_interfaces.action',
                             reason='needs pip install ./baxter_dynamics_interfaces')
pytest.importorskip('scipy', reason='calibration needs SciPy')
pytest.importorskip('yaml', reason='parameter files need PyYAML')

LEFT = ('-p', 'arm:=left')
pytestmark = pytest.mark.timeout(400)  # a busy machine leaves little to the fit
BEGIN = 1_700_000_000_000_000_000  # [ns]


@pytest.fixture(scope='module')
def tracking(recordings):
    """Return a function: rows (q, qd, effort) of a recording of the left arm."""
    with np.load(recordings / 'baxter_left_arm_tracking.npz') as file:
        data = {key: file[key] for key in file}
    order = [tuple(data['joint_names']).index(name) for name in joint_names('left')]

    def rows(recording, begin, end):
        chosen = np.flatnonzero(data['recording'] == recording)[begin:end]
        return list(zip(*(data[key][chosen][:, order]
                          for key in ('position', 'velocity', 'effort'))))
    return rows


@pytest.fixture
def calibrate(robot):
    """Return a function that sends a goal; it returns a handle with feedback and result()."""
    client = ActionClient(robot, action.Calibrate, '/torque_predictor/calibrate')
    robot.acts = True

    def send(**goal):
        assert client.wait_for_server(30.0)
        feedback = []
        sent = client.send_goal_async(action.Calibrate.Goal(**goal),
                                      feedback_callback=lambda m: feedback.append(m.feedback))
        robot.until(sent.done)
        handle = sent.result()
        assert handle.accepted
        future = handle.get_result_async()

        def result():
            robot.until(future.done, 240.0)
            return future.result().status, future.result().result
        return SimpleNamespace(feedback=feedback, result=result, done=future.done,
                               cancel=handle.cancel_goal_async)
    yield send
    robot.acts = False
    client.destroy()


def live_residual(robot, rows, start):
    """Return the residuals (n, 7) of rows played to the node [N m]."""
    robot.residual.clear()
    last = robot.stream(rows, start, 'left')
    robot.until(lambda: robot.residual
                and stamp_ns(robot.residual[-1].header) > last - 60_000_000)
    return np.array([message.effort for message in robot.residual])


def test_a_fit_can_be_cancelled(robot, calibrate, tracking):
    robot.start_predictor(*LEFT)
    before = robot.parameters()
    rows = tracking(0, 900, 2100)
    robot.stream(rows[:50], start=BEGIN, side='left')
    goal = calibrate(duration=10.0, inertial=True)
    robot.stream(rows[50:1150], BEGIN + 500_000_000, 'left')
    robot.until(lambda: len(robot.predicted) == 1150 - 21)  # all is recorded
    robot.spin(0.5)
    assert not goal.done()
    goal.cancel()
    status, result = goal.result()
    assert status == GoalStatus.STATUS_CANCELED and 'cancelled' in result.message
    assert robot.parameters() == before


def test_goals_are_refused_with_the_reason_and_a_cancelled_one_changes_nothing(
        robot, calibrate, tracking):
    robot.start_predictor(*LEFT)
    before = robot.parameters()
    rows = tracking(0, 900, 1500)
    robot.spin(1.2)  # until the states of another test are too old
    for goal, problem in (
            ({'duration': 9.0}, 'duration: expected 10 to 600 s'),
            ({'duration': float('nan')}, 'duration: expected 10 to 600 s'),
            ({'duration': 20.0, 'file': '/nowhere/left.yaml'}, 'file: cannot write'),
            ({'duration': 20.0}, 'no valid joint states arrive')):
        status, result = calibrate(**goal).result()
        assert (status, result.success) == (GoalStatus.STATUS_ABORTED, False)
        assert problem in result.message and 'nothing was changed' in result.message

    robot.stream(rows[:50], start=BEGIN, side='left')
    goal = calibrate(duration=20.0)
    robot.stream(rows[50:100], start=BEGIN + 500_000_000, side='left')
    _, second = calibrate(duration=20.0).result()
    assert 'another calibration is running' in second.message
    robot.stream(rows[100:150], start=BEGIN + 10 ** 9, side='left')
    goal.cancel()
    robot.stream(rows[150:200], start=BEGIN + 1_500_000_000, side='left')
    status, result = goal.result()
    assert status == GoalStatus.STATUS_CANCELED and 'cancelled' in result.message

    goal = calibrate(duration=20.0)
    no_effort = [(q, qd, None) for q, qd, _ in rows[200:250]]
    robot.stream(no_effort, start=BEGIN + 2 * 10 ** 9, side='left')
    assert 'there is no measured effort' in goal.result()[1].message

    still = [(rows[0][0], np.zeros(7), rows[0][2])] * 1100
    robot.stream(still[:50], start=BEGIN + 20 * 10 ** 9, side='left')
    goal = calibrate(duration=10.0)
    robot.stream(still[50:], BEGIN + 20_500_000_000, 'left')
    status, result = goal.result()
    assert status == GoalStatus.STATUS_ABORTED and not result.success
    assert robot.parameters() == before

    robot.stream(rows[:50], start=BEGIN + 60 * 10 ** 9, side='left')
    goal = calibrate(duration=20.0)
    assert robot.configure({'payload.mass': 0.3}).successful
    robot.stream(rows[50:100], start=BEGIN + 60_500_000_000, side='left')
    assert 'parameters were changed meanwhile' in goal.result()[1].message
    assert robot.configure({'effort_model.enabled': False}).successful
    assert 'effort_model.enabled is false' in calibrate(duration=20.0).result()[1].message
    assert robot.configure({'effort_model.enabled': True, 'payload.mass': 0.0}).successful


def test_a_recording_calibrates_the_node_for_another(robot, calibrate, tracking, tmp_path):
    robot.start_predictor(*LEFT)
    other = tracking(6, 1000, 1300)
    before = live_residual(robot, other, BEGIN)

    file = tmp_path / 'left.yaml'
    robot.stream(tracking(0, 900, 950), start=BEGIN + 20 * 10 ** 9, side='left')
    goal = calibrate(duration=20.0, file=str(file))
    robot.stream(tracking(0, 950, 3100), BEGIN + 20_500_000_000, 'left')
    status, result = goal.result()
    print(result.message)
    assert status == GoalStatus.STATUS_SUCCEEDED and result.success, result.message
    assert list(result.joint_names) == list(joint_names('left'))
    assert [each.elapsed for each in goal.feedback] == sorted(
        each.elapsed for each in goal.feedback)
    assert goal.feedback[-1].elapsed > 1.0 and goal.feedback[-1].advice
    assert min(goal.feedback[-1].seen) > 0.0 and max(goal.feedback[-1].seen) <= 1.0
    assert np.sum(result.rms_after) < 0.8 * np.sum(result.rms_before)
    assert {parameter.name for parameter in result.parameters} >= {'effort_model.bias'}

    after = live_residual(robot, other, BEGIN + 120 * 10 ** 9)
    rms = [np.sqrt(np.mean(each ** 2, axis=0)) for each in (before, after)]
    print('residual RMS of another recording [N m], before and after:', *rms, sep='\n')
    assert np.sum(rms[1]) < 0.8 * np.sum(rms[0])

    set_now = robot.parameters()
    assert result.file == str(file)
    robot.start_predictor('--params-file', str(file))
    for value, wanted in zip(robot.parameters().values(), set_now.values()):
        np.testing.assert_array_equal(value, wanted) if isinstance(wanted, str) else (
            np.testing.assert_allclose(value, wanted, rtol=1e-6, atol=1e-9))
    again = live_residual(robot, other, BEGIN + 120 * 10 ** 9)
    # Seven digits in the file; pre-sliding friction forgets what was before.
    np.testing.assert_allclose(again[-100:], after[-100:], atol=1e-3)


@pytest.fixture
def alone(robot, monkeypatch):
    """
    Return a function: message of the action in this process, and what it held at each pause.

    Every second joint state is invalid, and the others come with gaps.
    """
    node, predictor = ParameterNode('calibrating'), Predictor(PredictorSettings())
    node.values, statistics = predictor.settings.parameters(), StepStatistics()
    server = CalibrateAction(node, predictor, statistics, action.Calibrate)
    message = joint_state(joint_names('right'), BEGIN, *np.ones((3, 7)))
    held, feedback = [], []

    async def pause():
        time.sleep(0.01)
        held.append((server._process is not None, server._kept is not None))
        for _ in range(10):
            set_stamp(message.header, stamp_ns(message.header) + 300_000_000)
            for q in np.ones(7), np.full(7, np.nan):
                message.position = to_field(q)
                step = predictor.handle(stamp_ns(message.header), message.name, q, q, q)
                statistics.add(step)
                server.add(message, 0, step)

    def run(**goal):
        handle = SimpleNamespace(request=action.Calibrate.Goal(**goal), is_cancel_requested=False,
                                 publish_feedback=feedback.append, abort=lambda: None)
        with pytest.raises(StopIteration):
            pause().send(None)
        with pytest.raises(StopIteration) as end:
            server._execute(handle).send(None)
        assert bool(feedback) == (goal['duration'] < 20.0)
        assert np.isfinite([each.seen for each in feedback]).all()
        return end.value.value.message, held
    monkeypatch.setattr(server, '_pause', pause)
    yield run
    server.destroy()
    node.destroy_node()


def test_joint_states_are_kept_only_until_the_fit(alone, monkeypatch):
    monkeypatch.setattr(live, 'COMMAND', ('sh', '-c', 'sleep 0.1; echo why'))
    message, held = alone(duration=10.0)
    assert message == 'nothing was changed: the fit failed: why'
    assert set(held[1:]) == {(False, True), (True, False)}
    monkeypatch.setattr(live, 'COMMAND', ('/nowhere',))
    assert '/nowhere' in alone(duration=10.0)[0]


def test_a_missing_library_is_named(alone, monkeypatch):
    monkeypatch.setattr(calibrate_action, 'find_spec', lambda name: None)
    assert alone(duration=20.0)[0].endswith('needs scipy pyyaml: pip install scipy pyyaml')

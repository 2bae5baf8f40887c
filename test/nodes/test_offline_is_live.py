"""The predictions that evaluate saves equal those of the running node."""

import json

from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
from baxter_dynamics_ros.nodes.messages import stamp_ns
import numpy as np
import pytest

pytest.importorskip('rosbags', reason='needs rosbags: pip install ".[offline]"')
pytest.importorskip('jinja2', reason='needs Jinja2: pip install ".[offline]"')

from baxter_dynamics_ros.recordings.parameter_file import write_parameters  # noqa: E402, I100
from sensor_msgs.msg import JointState  # noqa: E402

CALIBRATION = {
    'effort_model.coulomb': (0.61, 0.92, 0.43, 0.34, 0.15, 0.12, 0.05),
    'effort_model.dahl': (0.45, 1.1, 0.0, 0.3, 0.0, 0.05, 0.02),
    'effort_model.dahl_length': 0.013,
    'effort_model.bias': (0.5, -0.4, 0.3, 0.2, -0.1, 0.12, 0.05),
    'effort_model.stiffness': (-0.5, 0.0, 0.2, 0.0, 0.0, 0.1, 0.0),
    'effort_model.added_inertia': (0.25, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0),
    'effort_model.deviation': (0.3, 0.4, 0.2, 0.2, 0.1, 0.1, 0.05),
    'effort_model.deviation_velocity': (0.5, 0.3, 0.2, 0.2, 0.1, 0.1, 0.0),
    'effort_model.deviation_acceleration': (0.2, 0.3, 0.1, 0.1, 0.0, 0.0, 0.1),
    'acceleration.velocity_lag': 0.0137,
    'gravity': (0.15, -0.12, -9.8081),
    'payload.mass': 0.35,
    'payload.center_of_mass': (0.01, -0.02, 0.11),
}
GRIPPER = ('r_gripper_l_finger_joint', 'r_gripper_r_finger_joint')
CHUNK = 50  # messages sent before the node's answers to them are awaited
# What the stream handler must have met.
MET = {'not_this_arm', 'non_finite', 'out_of_order', 'duplicate', 'repeated_stamp', 'reset_gap',
       'reset_clock_jump', 'reset_position_jump', 'reset_velocity_source', 'effort_missing',
       'effort_all_zero', 'velocity_missing'}
TOPICS = ('/torque_predictor/predicted_effort', '/torque_predictor/effort_residual',
          '/torque_predictor/residual_deviation')


@pytest.fixture
def messages(moving_arm):
    """Return 8 s of joint states, with all that a stream handler must cope with."""
    arm = [content for _, _, content in moving_arm(800)]
    late = 0  # [ns]
    played = []
    for i, (stamp, names, q, qd, effort) in enumerate(arm):
        if i == 150:
            late += 400_000_000  # a gap: the filter starts anew
        if i == 500:
            late -= 30_000_000_000  # another clock
        stamp += late
        if i >= 250:
            q = q + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.3])  # a jump
        if 330 <= i < 370:
            effort = () if i % 2 else np.zeros(7)
        if 420 <= i < 460:
            qd = ()
        if i == 600:
            q = np.full(7, np.nan)
        if i == 620:
            stamp -= 25_000_000  # late
        if i == 640:
            stamp -= 10_000_000  # the stamp of the one before
        order = np.random.default_rng(i).permutation(7)  # joints are told by their names
        played.append((stamp, [names[j] for j in order], *(
            np.asarray(row)[order] if len(row) else [] for row in (q, qd, effort))))
        if i % 40 == 10:
            played.append(played[-1])  # a duplicate
        if i % 3 == 0:
            played.append((stamp, GRIPPER, *np.zeros((3, 2))))
    return [('/robot/joint_states', 10 ** 18 + 10 ** 6 * i, content)
            for i, content in enumerate(played)]


def test_evaluate_saves_what_the_node_publishes(
        robot, command, make_bag, read_bag, messages, tmp_path):
    parameters = tmp_path / 'my_robot.yaml'
    write_parameters(parameters, PredictorSettings.from_parameters(CALIBRATION))
    code, _, err = command('evaluate', make_bag(messages), '--params', parameters, '--output',
                           tmp_path / 'report', '--save-bag', tmp_path / 'new')
    assert (code, err) == (0, '')
    numbers = json.loads((tmp_path / 'report' / 'summary.json').read_text())
    assert MET <= set(numbers['recordings'][0]['counts'])
    offline = read_bag(tmp_path / 'new')
    received = [when for when, _ in offline[TOPICS[0]]]
    assert len(received) > 600 and len(offline[TOPICS[1]]) < len(received)

    deviation = []
    robot.create_subscription(JointState, TOPICS[2], deviation.append, 1000)
    robot.start_predictor('--params-file', str(parameters))
    for k in range(0, len(messages), CHUNK):
        for _, when, content in messages[k:k + CHUNK]:
            robot.send(*content)
        expected = np.searchsorted(received, when, 'right')
        robot.until(lambda: len(robot.predicted) >= expected)  # so that none is lost
    for topic, live in zip(TOPICS, (robot.predicted, robot.residual, deviation)):
        robot.until(lambda: len(live) >= len(offline[topic]))
        saved = [message for _, message in offline[topic]]
        assert [stamp_ns(m.header) for m in live] == [
            m.header.stamp.sec * 10 ** 9 + m.header.stamp.nanosec for m in saved]
        for ours, theirs in zip(saved, live):
            assert ours.name == theirs.name == list(joint_names('right'))
            assert ours.header.frame_id == theirs.header.frame_id == 'base'
        for field in ('position', 'velocity', 'effort'):
            ours, theirs = (np.array([getattr(m, field) for m in messages_])
                            for messages_ in (saved, live))
            print(f'{topic}, {field}: they differ by {np.abs(ours - theirs).max():.1e} at most')
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9)

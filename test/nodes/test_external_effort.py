"""A push on the fake arm is published as external effort, wrench and contact."""

from baxter_dynamics_ros.model.joints import JOINTS
from geometry_msgs.msg import WrenchStamped
import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

PUSH = np.array([0.0, 0.0, -25.0])  # [N]


@pytest.fixture
def push(robot, start):
    """Start a fake Baxter that holds still; return a function that sets the force on its hand."""
    start('fake_baxter', '-p', 'trajectory:=hold')
    client = robot.create_client(SetParameters, '/fake_baxter/set_parameters')
    assert client.wait_for_service(timeout_sec=15.0)

    def set_force(force):
        future = client.call_async(SetParameters.Request(parameters=[
            Parameter('force', value=force.tolist()).to_parameter_msg()]))
        rclpy.spin_until_future_complete(robot, future, timeout_sec=10.0)
        return future.result().results[0]
    return set_force


def test_a_push_appears_in_effort_wrench_contact_and_diagnostics(robot, push, start_predictor):
    start_predictor('-p', 'wrench_frame:=base')
    external = robot.listen(JointState, '/torque_predictor/external_effort')
    wrenches = robot.listen(WrenchStamped, '/torque_predictor/external_wrench')
    contacts = robot.listen(Bool, '/torque_predictor/contact')
    robot.until(lambda: len(external) > 200)
    free = np.mean([m.effort for m in external[-50:]], axis=0)
    residual = np.mean([m.effort for m in robot.residual[-50:]], axis=0)
    wrench = wrenches[-1].wrench.force.z
    assert not any(m.data for m in contacts[-150:])

    contacts.clear()
    refused = push(1e5 * PUSH)
    assert not refused.successful and 'force' in refused.reason
    assert push(PUSH).successful
    robot.until(lambda: any(m.data for m in contacts))
    _, message, values = robot.report()['external']
    assert message.startswith('contact at ')
    assert values['contact'] == 'True'
    assert 's1' in values['joints in contact']
    robot.spin(0.5)
    pushed = np.mean([m.effort for m in external[-20:]], axis=0) - free
    assert pushed[1] > 10.0  # s1 turns the arm down when positive
    # The residual has the other sign.
    np.testing.assert_allclose(
        np.mean([m.effort for m in robot.residual[-20:]], axis=0) - residual, -pushed, atol=1.0)
    assert wrenches[-1].header.frame_id == 'base'
    assert wrenches[-1].wrench.force.z - wrench == pytest.approx(PUSH[2], abs=5.0)
    assert robot.report()['external'][2]['contact'] == 'True'  # far beyond what a model may lack

    push(np.zeros(3))
    robot.until(lambda: not contacts[-1].data)
    by_stamp = {m.header.stamp.sec * 10 ** 9 + m.header.stamp.nanosec: m for m in external}
    for m in wrenches:
        assert m.header.stamp.sec * 10 ** 9 + m.header.stamp.nanosec in by_stamp


def test_topics_without_subscribers_are_not_published(robot, predictor, sine):
    t = np.arange(100) * 0.01
    q, qd, _ = sine(t)
    robot.stream(zip(q, qd, q))
    robot.until(lambda: len(robot.predicted) == 79)
    late = robot.listen(Bool, '/torque_predictor/contact')
    robot.spin(0.5)
    assert late == []


def test_the_wrench_is_withheld_with_a_straight_elbow(robot, predictor):
    wrenches = robot.listen(WrenchStamped, '/torque_predictor/external_wrench')
    external = robot.listen(JointState, '/torque_predictor/external_effort')
    straight = np.array([0.1, -0.5, 0.2, 0.16, 0.3, 0.6, -0.2])
    bent = straight + [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    reports = []
    for number, q in enumerate((straight, bent)):
        robot.stream([(q, np.zeros(7), np.ones(7))] * 200, start=10 ** 18 + number * 10 ** 10,
                     pace=0.01)
        robot.until(lambda: len(external) == (197 if number else 0) + 198)
        reports.append(robot.statuses()[-1]['external'])
        assert bool(wrenches) == (q is bent)
    (_, message, keys), (_, later, told) = reports
    assert message.endswith('not published near a singularity of the hand')
    assert int(keys['wrenches withheld']) > 50
    assert keys['unexplained by a wrench [N m]'] == 'none'
    assert 'singularity' not in later
    assert float(told['unexplained by a wrench [N m]']) >= 0.0
    for name in ('bias', 'sigma', 'threshold'):
        assert all(np.isfinite(float(told[f'{joint} {name} [N m]'])) for joint in JOINTS)

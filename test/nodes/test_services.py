"""Services gravity_torques and inverse_dynamics."""

from baxter_dynamics_ros import BaxterArm
from baxter_dynamics_ros.model import EffortModel, joint_names
from baxter_dynamics_ros.nodes.messages import joint_state, stamp_ns
import numpy as np
from perfect_robot import trajectory
import pytest
from robot_node import PATIENCE

srv = pytest.importorskip('baxter_dynamics_interfaces.srv',
                          reason='needs pip install ./baxter_dynamics_interfaces')

NAMES = joint_names('right')
Q = np.array([0.3, -0.7, 0.2, 1.1, -0.3, 0.9, 0.4])
QD = np.array([0.5, -0.4, 0.3, 0.6, -0.7, 0.2, 0.9])
QDD = np.array([1.0, -2.0, 0.5, 1.5, -3.0, 2.0, 4.0])


@pytest.fixture
def node(robot):
    """Return the test's own node beside a predictor that checks the fields of its messages."""
    robot.start_predictor(ROS_PYTHON_CHECK_FIELDS='1')
    return robot


def shuffled(*fields):
    """Return the fields of a robot with 17 joints in a strange order, the arm's among them."""
    names = list(NAMES) + ['head_pan', 'left_s0', 'left_s1', 'torso_t0']
    order = np.random.default_rng(4).permutation(len(names))
    rows = [np.append(field, [9.0, 8.0, 7.0, 6.0])[order] for field in fields]
    return [names[i] for i in order], rows


def test_answers_by_name_in_any_order(node):
    names, (q, qd, qdd) = shuffled(Q, QD, QDD)
    arm, effort = BaxterArm(), EffortModel()

    answer = node.call(srv.GravityTorques, 'gravity_torques', srv.GravityTorques.Request(
        state=joint_state(names, 5, q)))
    assert answer.success, answer.message
    assert tuple(answer.gravity.name) == NAMES
    assert stamp_ns(answer.gravity.header) == 5
    np.testing.assert_array_equal(answer.gravity.position, Q)
    np.testing.assert_allclose(answer.gravity.effort, arm.gravity(Q), atol=1e-12)
    expected = effort.coupled(arm.gravity(Q) + effort.spring(Q))
    np.testing.assert_allclose(answer.actuator_effort, expected, atol=1e-12)

    request = srv.InverseDynamics.Request(state=joint_state(names, 5, q, qd), acceleration=qdd)
    answer = node.call(srv.InverseDynamics, 'inverse_dynamics', request)
    assert answer.success, answer.message
    mass, coriolis, gravity = arm.terms(Q, QD)
    tau = arm.inverse_dynamics(Q, QD, QDD)
    assert tuple(answer.torque.name) == NAMES
    np.testing.assert_allclose(answer.torque.effort, tau, atol=1e-12)
    np.testing.assert_allclose(answer.inertial, mass @ QDD, atol=1e-12)
    np.testing.assert_allclose(answer.coriolis, coriolis @ QD, atol=1e-12)
    np.testing.assert_allclose(answer.gravity, gravity, atol=1e-12)
    np.testing.assert_allclose(answer.actuator_effort, effort.effort(tau, Q, QD, QDD), atol=1e-12)
    np.testing.assert_allclose(np.reshape(answer.mass_matrix, (7, 7)), mass, atol=1e-12)
    np.testing.assert_allclose(np.reshape(answer.coriolis_matrix, (7, 7)), coriolis, atol=1e-12)

    # Empty velocity and acceleration of a given state are zero.
    answer = node.call(srv.InverseDynamics, 'inverse_dynamics',
                       srv.InverseDynamics.Request(state=joint_state(NAMES, 0, Q)))
    np.testing.assert_allclose(answer.torque.effort, BaxterArm().gravity(Q), atol=1e-12)
    assert not np.any(answer.inertial) and not np.any(answer.coriolis)


def test_the_answer_says_when_the_spring_is_held(node):
    state = joint_state(NAMES, 0, np.where(np.arange(7) == 1, -2.1, Q))
    state.header.stamp.sec, state.header.stamp.nanosec = 2 ** 31 - 1, 2 ** 32 - 1
    answer = node.call(srv.GravityTorques, 'gravity_torques',
                       srv.GravityTorques.Request(state=state))
    assert answer.success and 'spring' in answer.message


def test_empty_request_is_for_the_latest_state_until_it_is_too_old(node):
    clients = [node.create_client(kind, f'/torque_predictor/{name}') for kind, name in (
        (srv.GravityTorques, 'gravity_torques'), (srv.InverseDynamics, 'inverse_dynamics'))]
    assert all(client.wait_for_service(PATIENCE) for client in clients)

    def ask():
        futures = [client.call_async(client.srv_type.Request()) for client in clients]
        node.until(lambda: all(future.done() for future in futures))
        return [future.result() for future in futures]
    t = np.arange(0.0, 1.0, 0.01)
    q, qd, _ = trajectory(t)
    last = node.stream([(a, b, np.ones(7)) for a, b in zip(q, qd)])
    node.until(lambda: len(node.predicted) == len(t) - 21)

    gravity, torque = ask()
    assert gravity.success, gravity.message
    assert stamp_ns(gravity.gravity.header) == last
    np.testing.assert_array_equal(gravity.gravity.position, q[-1])
    np.testing.assert_allclose(gravity.gravity.effort, BaxterArm().gravity(q[-1]), atol=1e-12)

    assert torque.success, torque.message
    newest = node.predicted[-1]
    assert torque.torque.header.stamp == newest.header.stamp
    np.testing.assert_array_equal(torque.torque.position, newest.position)
    np.testing.assert_array_equal(torque.torque.velocity, newest.velocity)
    np.testing.assert_allclose(torque.actuator_effort, newest.effort, atol=1e-12)

    node.spin(1.2)
    for answer in ask():
        assert not answer.success
        assert 'right_s0' in answer.message and 'arrived for' in answer.message


REFUSED = [
    ((), (), 'has arrived'),
    ((NAMES[:6], Q[:6]), (), 'lacks right_w2'),
    ((NAMES + NAMES[:1], [*Q, 0.0]), (), 'twice'),
    ((NAMES, Q[:6]), (), 'state.position: expected 7 values'),
    ((NAMES, Q, QD[:3]), (), 'state.velocity: expected 7 values'),
    ((NAMES, [*Q[:6], np.nan]), (), 'state.position: expected finite'),
    ((NAMES, Q), QDD[:2], 'acceleration: expected 7 values'),
    ((NAMES, Q), [*QDD[:6], np.inf], 'acceleration: expected finite'),
    ((NAMES, np.degrees(Q)), (), 'state.position: expected at most'),
    ((NAMES, Q, 1e200 * QD), (), 'state.velocity: expected at most'),
    ((NAMES, Q), 1e307 * QDD, 'acceleration: expected at most'),
    (((), Q), (), 'state.name: empty'),
    ((), QDD, 'acceleration: has the order'),
]


def test_bad_requests_are_refused_with_the_reason(node):
    for state, acceleration, problem in REFUSED:
        names, *fields = state or ((),)
        message = joint_state(names, 0, *(np.array(field, dtype=float) for field in fields))
        answer = node.call(srv.InverseDynamics, 'inverse_dynamics', srv.InverseDynamics.Request(
            state=message, acceleration=[float(x) for x in acceleration]))
        assert not answer.success
        assert problem in answer.message, problem
        assert len(answer.torque.effort) == 0
        if not problem.startswith(('acceleration', 'state.velocity')):
            answer = node.call(srv.GravityTorques, 'gravity_torques',
                               srv.GravityTorques.Request(state=message))
            assert not answer.success
            assert problem in answer.message

"""One process for both arms: what each gets, and the parameters that each has of its own."""

from baxter_dynamics_interfaces.srv import GravityTorques
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names, SIDES
import numpy as np
import pytest
from rcl_interfaces.srv import ListParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

START = 10 ** 18
LOAD = {'right': 0.5, 'left': 1.2}  # [kg]


@pytest.fixture
def topics(robot, start_predictor):
    """Start the predictor on both arms; return side to (predicted, residual, external)."""
    start_predictor('-p', 'arm:=both', '-p', f'right.payload.mass:={LOAD["right"]}',
                    '-p', f'left.payload.mass:={LOAD["left"]}')
    return {side: [robot.listen(JointState, f'/torque_predictor/{side}/{name}') for name in (
        'predicted_effort', 'effort_residual', 'external_effort')] for side in SIDES}


def send_both(robot, sine, first=0, last=60):
    """Send joint states of both arms, the left elsewhere than the right; return them."""
    names = joint_names('right') + joint_names('left')
    q, qd, _ = sine(np.arange(last) * 0.01)
    rows = [(np.concatenate([q[k], -0.5 * q[k]]), np.concatenate([qd[k], -0.5 * qd[k]]),
             np.concatenate([q[k] + 1.0, q[k] - 1.0])) for k in range(last)]
    for k in range(first, last):
        robot.send(START + k * 10_000_000, names, *rows[k])
        robot.spin(0.01)
    return names, rows


def test_each_arm_gets_what_a_predictor_of_its_own_computes(robot, topics, sine):
    names, rows = send_both(robot, sine)
    robot.until(lambda: all([len(messages) for messages in topics[side]] == [
        len(rows) - 21, len(rows) - 21, len(rows) - 2] for side in SIDES))
    for side in SIDES:
        alone = PredictorSettings({'arm': side, 'payload.mass': LOAD[side]}).predictor(
            external=True)
        expected = [alone.handle(START + k * 10_000_000, names, *row)
                    for k, row in enumerate(rows)]
        predicted, residual, external = topics[side]
        wanted = [step.prediction for step in expected if step.prediction]
        assert [list(m.effort) for m in predicted] == [p.effort.tolist() for p in wanted]
        assert [list(m.effort) for m in residual] == [p.residual.tolist() for p in wanted]
        assert [list(m.effort) for m in external] == [
            step.external.effort.tolist() for step in expected if step.external]
        assert all(tuple(m.name) == joint_names(side) for m in predicted + residual + external)

    for side in SIDES:
        gravity = robot.call(GravityTorques, f'{side}/gravity_torques')
        assert gravity.success, gravity.message
        arm = PredictorSettings({'arm': side, 'payload.mass': LOAD[side]}).arm
        order = [names.index(name) for name in joint_names(side)]
        np.testing.assert_allclose(
            gravity.gravity.effort, arm.gravity(rows[-1][0][order]), atol=1e-12)
    report = robot.report()
    assert set(report) == {f'torque_predictor/{side}: {name}' for side in SIDES for name in (
        'input', 'stamps', 'filter', 'effort', 'residual', 'external')}
    assert robot.call(Trigger, 'reset').success
    send_both(robot, sine, 60, 70)
    assert all(len(topics[side][1]) == len(rows) - 21 for side in SIDES)


def test_parameters_of_an_arm_bear_its_name_and_reach_it_alone(robot, topics, sine):
    names = robot.call(ListParameters, 'list_parameters').result.names
    assert {'right.payload.mass', 'left.effort_model.bias', 'gravity', 'arm'} <= set(names)
    assert not {'payload.mass', 'effort_model.bias', 'right.gravity'} & set(names)

    def set_(name, value):
        return robot.call(SetParametersAtomically, 'set_parameters_atomically',
                          SetParametersAtomically.Request(parameters=[
                              Parameter(name, value=value).to_parameter_msg()])).result
    refused = set_('left.payload.mass', -1.0)
    assert not refused.successful and 'left.payload.mass' in refused.reason
    send_both(robot, sine)
    robot.until(lambda: all(len(topics[side][0]) == 39 for side in SIDES))
    before = {side: np.array(topics[side][0][-1].effort) for side in SIDES}
    assert set_('left.effort_model.bias', [1.0] * 7).successful
    send_both(robot, sine, 60, 61)
    robot.until(lambda: all(len(topics[side][0]) == 40 for side in SIDES))
    change = {side: np.array(topics[side][0][-1].effort) - before[side] for side in SIDES}
    assert (change['left'] - change['right'] > 0.5).all()


def test_a_parameter_without_the_arms_name_is_refused(refuses):
    refuses('torque_predictor', ['arm:=both', 'payload.mass:=1.0'],
            'payload.mass: no such parameter; is right.payload.mass or left.payload.mass meant?')

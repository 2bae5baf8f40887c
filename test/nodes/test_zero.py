"""Service zero: adds constant offsets of measured effort to the bias, or refuses."""

from itertools import cycle, islice

from baxter_dynamics_ros.estimation.settings import PredictorSettings
import numpy as np
from perfect_robot import rows
import pytest
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

START = 10 ** 18  # [ns]
OFFSET = [0.5, 34.0, -0.8, 0.3, 0.1, -0.2, 0.05]  # [N m]
CROSSTALK = np.zeros((7, 7))
CROSSTALK[3, 2] = -0.2


@pytest.fixture
def zero(robot):
    """Return a function: answer to a request made while the arm moves with an effort."""
    process = robot.start_predictor('-p', f'effort_model.crosstalk:={CROSSTALK.ravel().tolist()}')
    client = robot.create_client(Trigger, '/torque_predictor/zero')
    assert client.wait_for_service(30.0)
    truth = PredictorSettings.from_parameters({
        'effort_model.bias': OFFSET, 'effort_model.crosstalk': CROSSTALK.ravel().tolist()})
    messages = cycle(rows(0.01 * np.arange(2000), truth))  # the period of the motion
    sent = 0

    def stream(n, change=lambda effort: effort):
        nonlocal sent
        robot.stream([(q, qd, change(effort)) for q, qd, effort in islice(messages, n)],
                     start=START + sent * 10_000_000)
        sent += n

    def zero_(n, change=lambda effort: effort, parameters={}, before=lambda effort: effort):
        future = client.call_async(Trigger.Request())
        if n:
            second = client.call_async(Trigger.Request())
            robot.until(lambda: second.done() or stream(10, before))
            assert 'another request is running' in second.result().message
            assert not parameters or robot.configure(parameters).successful
            stream(20, before)  # joint states may overtake the request
            stream(n, change)
        robot.until(future.done)
        return future.result()
    zero_.stream, zero_.process = stream, process
    return zero_


def without_offset(effort):
    """Return an effort without the offset."""
    return effort - OFFSET


@pytest.mark.parametrize('change, parameters, problem', [
    (lambda effort: effort - OFFSET + 25.0 * np.eye(7)[1], {}, 'contact began'),
    (lambda effort: None, {}, 'there is no measured effort'),
    (lambda effort: 0.0 * effort, {}, 'there is no measured effort'),
    (without_offset, {'contact.memory': 31.0}, 'parameters were changed')],
    ids=['contact', 'no effort', 'zero effort', 'parameters'])
def test_refused_requests_change_nothing(robot, zero, change, parameters, problem):
    zero.stream(100, without_offset)
    answer = zero(100, change, parameters, without_offset)
    assert not answer.success and 'nothing was changed' in answer.message
    assert problem in answer.message, answer.message
    assert not np.any(robot.parameters()['effort_model.bias'])


def test_offsets_go_into_the_bias(robot, zero):
    robot.spin(1.2)  # until the states of another test are too old
    answer = zero(0)
    assert not answer.success and 'no valid joint states arrive' in answer.message
    zero.stream(100)
    answer = zero(450)
    assert answer.success, answer.message
    assert 's1 +34.' in answer.message and 'contact was reported throughout' in answer.message

    np.testing.assert_allclose(robot.parameters()['effort_model.bias'], OFFSET, atol=0.05)
    contacts = robot.listen(Bool, '/torque_predictor/contact')
    robot.residual.clear()
    zero.stream(100)
    robot.until(lambda: len(robot.residual) > 90 and contacts)
    assert np.abs([m.effort for m in robot.residual]).max() < 0.2
    assert not contacts[-1].data
    zero.process.end()  # its bias is changed

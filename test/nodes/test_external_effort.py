"""External effort, wrench, contact, and the payload that explains the residual."""

from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import (joint_names, JOINTS, POSITION_LOWER,
                                              POSITION_UPPER)
from baxter_dynamics_ros.nodes.messages import stamp_ns
from baxter_dynamics_ros.simulation.description import find_description
from geometry_msgs.msg import InertiaStamped, WrenchStamped
import numpy as np
import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

PUSH = np.array([0.0, 0.0, -25.0])  # [N]
LOAD = 1.0  # [kg]
CENTER = [0.0, 0.02, 0.1]  # [m]
POSES = 4
START = 10 ** 18  # [ns]


@pytest.fixture
def hand(pin):
    """Return a function: Jacobian (6, 7) of the description's hand in its own axes."""
    model = pin.buildModelFromUrdf(str(find_description()))
    frame = model.getFrameId('left_hand_link', pin.FrameType.BODY)
    index = [model.joints[model.getJointId(name)].idx_q for name in joint_names('left')]
    columns = [model.joints[model.getJointId(name)].idx_v for name in joint_names('left')]
    data = model.createData()

    def jacobian(q):
        full = pin.neutral(model)
        full[index] = q
        return pin.computeFrameJacobian(
            model, data, full, frame, pin.ReferenceFrame.LOCAL)[:, columns]
    return jacobian


def test_the_wrench_is_withheld_with_a_straight_elbow(robot, predictor):
    wrenches = robot.listen(WrenchStamped, '/torque_predictor/external_wrench')
    external = robot.listen(JointState, '/torque_predictor/external_effort')
    straight = np.array([0.1, -0.5, 0.2, 0.16, 0.3, 0.6, -0.2])
    bent = straight + [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]

    def report_on(q, number, condition):
        return robot.move_until_report(
            lambda report: condition(report['external']), [(q, np.zeros(7), np.ones(7))],
            START + number * 10 ** 12)['external']

    _, message, keys = report_on(straight, 0, lambda each: int(each[2]['wrenches withheld']) > 50)
    assert message.endswith('not published near a singularity of the hand')
    assert keys['unexplained by a wrench [N m]'] == 'none'
    assert external and not wrenches
    _, message, keys = report_on(bent, 1, lambda each: 'singularity' not in each[1] and wrenches)
    assert float(keys['unexplained by a wrench [N m]']) >= 0.0
    for name in ('bias', 'sigma', 'threshold'):
        assert all(np.isfinite(float(keys[f'{joint} {name} [N m]'])) for joint in JOINTS)


def test_wrench_in_random_poses_is_that_of_the_manufacturers_description(robot, hand, rng):
    robot.start_predictor('-p', 'arm:=left')
    wrenches = robot.listen(WrenchStamped, '/torque_predictor/external_wrench')
    model = PredictorSettings(arm='left').model
    for k in range(POSES):
        q = rng.uniform(0.8 * POSITION_LOWER, 0.8 * POSITION_UPPER)
        q[3], q[5] = 1.2, 0.9  # clear of singularities
        wrench = rng.uniform(-20.0, 20.0, 6) * [1, 1, 1, 0.2, 0.2, 0.2]  # [N, N m]
        still = np.zeros(7)
        effort = model.effort_model.effort(
            model.arm.gravity(q) - hand(q).T @ wrench, q, still, still)
        wrenches.clear()
        last = robot.stream([(q, still, effort)] * 100, start=START + k * 10 ** 10, side='left')
        robot.until(lambda: wrenches
                    and stamp_ns(wrenches[-1].header) > last - 20_000_000)
        found = wrenches[-1]
        assert found.header.frame_id == 'left_hand'
        force, torque = found.wrench.force, found.wrench.torque
        np.testing.assert_allclose(
            [force.x, force.y, force.z, torque.x, torque.y, torque.z], wrench, atol=0.05)


def test_a_push_appears_in_effort_wrench_contact_and_diagnostics(robot, start, stamps):
    start('fake_baxter', '-p', 'trajectory:=hold')
    robot.start_predictor('-p', 'wrench_frame:=base')

    def push(force):
        return robot.configure({'force': force.tolist()}, 'fake_baxter')
    external = robot.listen(JointState, '/torque_predictor/external_effort')
    wrenches = robot.listen(WrenchStamped, '/torque_predictor/external_wrench')
    contacts = robot.listen(Bool, '/torque_predictor/contact')
    robot.until(lambda: len(external) > 150)
    free = np.mean([m.effort for m in external[-50:]], axis=0)
    residual = np.mean([m.effort for m in robot.residual[-50:]], axis=0)
    wrench = wrenches[-1].wrench.force.z
    assert not any(m.data for m in contacts[-50:])

    contacts.clear()
    refused = push(1e5 * PUSH)
    assert not refused.successful and 'force' in refused.reason
    assert push(PUSH).successful
    robot.until(lambda: sum(m.data for m in contacts) > 80)  # and all filters have settled
    _, message, values = robot.report()['external']
    assert message.startswith('contact at ')
    assert values['contact'] == 'True'
    assert 's1' in values['joints in contact']
    pushed = np.mean([m.effort for m in external[-20:]], axis=0) - free
    assert pushed[1] > 10.0  # s1 turns the arm down when positive
    # The residual has the other sign.
    np.testing.assert_allclose(
        np.mean([m.effort for m in robot.residual[-20:]], axis=0) - residual, -pushed, atol=1.0)
    assert wrenches[-1].header.frame_id == 'base'
    assert wrenches[-1].wrench.force.z - wrench == pytest.approx(PUSH[2], abs=5.0)

    push(np.zeros(3))
    robot.until(lambda: not contacts[-1].data)
    published = set(stamps(wrenches))
    robot.until(lambda: published <= set(stamps(external)))


def test_a_payload_is_explained_and_published(robot, start, stamps):
    deviation = (0.5 * np.ones(7)).tolist()  # [N m]
    robot.start_predictor('-p', f'effort_model.deviation:={deviation}', *(
        text for of in ('velocity', 'acceleration')
        for text in ('-p', f'effort_model.deviation_{of}:={[0.0] * 7}')))
    deviations = robot.listen(JointState, '/torque_predictor/residual_deviation')
    payloads = robot.listen(InertiaStamped, '/torque_predictor/payload_estimate')
    start('fake_baxter', '-p', f'payload.mass:={LOAD}', '-p', f'payload.center_of_mass:={CENTER}')
    robot.until(lambda: payloads and payloads[-1].inertia.m == pytest.approx(LOAD, abs=0.2))
    assert payloads[-1].header.frame_id == 'right_hand'
    robot.until(lambda: any('kg at the hand' in report['residual'][2]['explanation']
                            for report in robot.statuses()))
    published = set(stamps(deviations))
    robot.until(lambda: published and published <= set(stamps(robot.residual)))
    assert all(list(each.effort) == deviation for each in deviations)

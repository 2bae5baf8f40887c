"""Explanation of the residual and payload estimate of the running node."""

from geometry_msgs.msg import InertiaStamped
import numpy as np
import pytest
from sensor_msgs.msg import JointState

pytest.importorskip('mujoco', reason='needs MuJoCo: pip install ".[demo]"')

LOAD = 1.0  # [kg]
CENTER = [0.0, 0.02, 0.1]  # [m]


def test_a_payload_is_explained_and_published(robot, start, start_predictor, stamps):
    deviation = (0.5 * np.ones(7)).tolist()  # [N m]
    start_predictor('-p', f'effort_model.deviation:={deviation}', *(
        text for of in ('velocity', 'acceleration')
        for text in ('-p', f'effort_model.deviation_{of}:={[0.0] * 7}')))
    deviations = robot.listen(JointState, '/torque_predictor/residual_deviation')
    payloads = robot.listen(InertiaStamped, '/torque_predictor/payload_estimate')
    start('fake_baxter', '-p', f'payload.mass:={LOAD}', '-p', f'payload.center_of_mass:={CENTER}')
    robot.until(lambda: payloads, 30.0)
    robot.spin(4.0)
    inertia = payloads[-1].inertia
    print(inertia.m, inertia.com)
    assert payloads[-1].header.frame_id == 'right_hand'
    assert inertia.m == pytest.approx(LOAD, abs=0.2)
    robot.until(lambda: any(report['residual'][2]['explanation'].startswith('residual is what ')
                            for report in robot.statuses()))
    assert deviations and set(stamps(deviations)) <= set(stamps(robot.residual))
    assert all(list(each.effort) == deviation for each in deviations)

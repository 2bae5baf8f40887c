"""External wrench in the axes of the hand, against Pinocchio on the manufacturer's description."""

from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names, POSITION_LOWER, POSITION_UPPER
from baxter_dynamics_ros.nodes.messages import stamp_ns
from baxter_dynamics_ros.simulation.description import find_description
from geometry_msgs.msg import WrenchStamped
import numpy as np
import pytest

POSES = 6
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


def test_wrench_is_that_of_the_description_in_random_poses(
        robot, start_predictor, hand, rng):
    start_predictor('-p', 'arm:=left')
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

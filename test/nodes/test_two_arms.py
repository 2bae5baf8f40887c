"""Two arms are two nodes: each predicts its arm from the same joint states."""

from baxter_dynamics_ros.estimation.predictor import Predictor
from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names, SIDES
import numpy as np
from sensor_msgs.msg import JointState

START = 10 ** 18
LOAD = {'right': 0.5, 'left': 1.2}  # [kg]
LOSSLESS = ('-p', 'qos_overrides./robot/joint_states.subscription.reliability:=reliable')


def test_each_node_predicts_its_arm_with_its_parameters(robot, start, sine):
    for side in SIDES:
        start('torque_predictor', '-r', f'__ns:=/{side}', '-p', f'arm:={side}',
              '-p', f'payload.mass:={LOAD[side]}', *LOSSLESS)
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
            {'arm': side, 'payload.mass': LOAD[side]}))
        steps = [alone.handle(START + k * 10_000_000, names, *row) for k, row in enumerate(rows)]
        assert [list(m.effort) for m in residuals[side]] == [
            step.prediction.residual.tolist() for step in steps if step.prediction]
        assert all(tuple(m.name) == joint_names(side) for m in residuals[side])

"""The predictor on a simulator's joint states, as gz_ros2_control publishes them for Baxter."""

from pathlib import Path
import signal

from baxter_dynamics_ros.estimation.settings import PredictorSettings
from baxter_dynamics_ros.model.joints import joint_names
import numpy as np
import pytest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

NAMES = [f'{side}_{joint}' for side in ('left', 'right')
         for joint in ('e0', 'e1', 's0', 's1', 'w0', 'w1', 'w2')] + [
             'head_pan', 'l_gripper_l_finger_joint', 'r_gripper_l_finger_joint']
SIMULATED = Path(__file__).parents[2] / 'config' / 'simulation.yaml'


@pytest.fixture
def simulator(robot):
    """Return a function that plays a motion at times t [s]; effort nan, absent or present."""
    publisher = robot.create_publisher(JointState, '/joint_states', 1000)
    clock = robot.create_publisher(Clock, '/clock', 10)
    arm = PredictorSettings().model.arm

    def play(sine, t, effort):
        for x in t:
            q, qd, qdd = (row[0] for row in sine(np.array([x])))
            tau = arm.inverse_dynamics(q, qd, qdd)
            stamp = round(x * 1e9)
            rows = []
            for values in (q, qd, tau):
                of = dict(zip(joint_names('right'), values))
                rows.append([float(of.get(name, 0.1)) for name in NAMES])
            rows[2] = {'nan': [float('nan')] * len(NAMES), 'absent': [],
                       'present': rows[2]}[effort]
            message = JointState(name=NAMES, position=rows[0], velocity=rows[1], effort=rows[2])
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10 ** 9)
            tick = Clock()
            tick.clock = message.header.stamp
            clock.publish(tick)
            publisher.publish(message)
            robot.spin(0.004)
    play.publisher = publisher
    return play


@pytest.mark.parametrize('effort', ['nan', 'absent', 'present'])
def test_predictions_in_simulated_time_and_again_after_a_reset_of_the_world(
        robot, start, simulator, sine, stamps, effort):
    process = start('torque_predictor', '--params-file', str(SIMULATED),
                    '-p', 'use_sim_time:=true', '-r', '/robot/joint_states:=/joint_states',
                    '-p', 'qos_overrides./joint_states.subscription.reliability:=reliable',
                    '-p', 'qos_overrides./joint_states.subscription.depth:=1000')
    robot.until(lambda: simulator.publisher.get_subscription_count() > 0
                and robot.count_publishers('/torque_predictor/effort_residual') > 0)
    robot.spin(0.5)
    t = np.arange(0.01, 3.0, 0.01)
    for _ in range(2):  # the world begins anew, and its time with it
        robot.predicted.clear()
        robot.residual.clear()
        simulator(sine, t, effort)
        robot.until(lambda: robot.predicted and stamps(robot.predicted[-1:])[0] > 2.9e9, 5.0)
        robot.spin(0.5)  # the residuals, and what should not come
        assert len(robot.predicted) > 240
        when = np.array(stamps(robot.predicted)) * 1e-9
        assert 0.0 < when[0] < 0.6 and (np.diff(when) > 0.0).all() and when[-1] > 2.8
        q, _, _ = sine(when)
        assert np.abs(q - [message.position for message in robot.predicted]).max() < 0.01
        if effort == 'present':
            assert len(robot.residual) == len(robot.predicted)
            settled = [message.effort for message in robot.residual[50:]]
            assert np.abs(settled).max() < 0.5
        else:
            assert robot.residual == []
    assert process.end(signal.SIGINT) == 0

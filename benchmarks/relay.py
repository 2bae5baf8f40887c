"""The floor: a bare relay with the node's subscription and publishers, and no computation."""

import sys

from baxter_dynamics_ros.ros import topics
from baxter_dynamics_ros.ros.process import run
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState


class Relay(Node):
    """Publishes each joint state of 17 joints twice, cut to seven joints."""

    def __init__(self):
        super().__init__('torque_predictor')
        self._first = self.create_publisher(
            JointState, topics.PREDICTED_EFFORT, topics.PUBLISHER_QOS)
        self._second = self.create_publisher(
            JointState, topics.EFFORT_RESIDUAL, topics.PUBLISHER_QOS)
        self._subscription = self.create_subscription(
            JointState, topics.JOINT_STATES, self._on_joint_state, topics.SUBSCRIPTION_QOS,
            qos_overriding_options=QoSOverridingOptions.with_default_policies())

    def _on_joint_state(self, message):
        message.name = message.name[9:16]
        message.position = message.position[9:16]
        message.velocity = message.velocity[9:16]
        message.effort = message.effort[9:16]
        self._first.publish(message)
        self._second.publish(message)


if __name__ == '__main__':
    sys.exit(run(Relay, 'relay'))

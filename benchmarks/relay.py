"""The floor: a bare relay with the node's subscription and publishers, and no computation."""

import sys

from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.process import run
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool


class Relay(Node):
    """Publishes each joint state of 17 joints three times, cut to seven; a wrench; and a flag."""

    def __init__(self):
        super().__init__('torque_predictor')

        def publisher(kind, name):
            return self.create_publisher(kind, topics.below_node(name), topics.PUBLISHER_QOS)
        self._joint_states = [publisher(JointState, name) for name in (
            topics.PREDICTED_EFFORT, topics.EFFORT_RESIDUAL, topics.EXTERNAL_EFFORT)]
        self._wrench = publisher(WrenchStamped, topics.EXTERNAL_WRENCH)
        self._contact = publisher(Bool, topics.CONTACT)
        self._wrench_stamped, self._bool = WrenchStamped(), Bool()
        self._subscription = self.create_subscription(
            JointState, topics.JOINT_STATES, self._on_joint_state, topics.SUBSCRIPTION_QOS,
            qos_overriding_options=QoSOverridingOptions.with_default_policies())

    def _on_joint_state(self, message):
        message.name = message.name[9:16]
        message.position = message.position[9:16]
        message.velocity = message.velocity[9:16]
        message.effort = message.effort[9:16]
        for publisher in self._joint_states:
            publisher.publish(message)
        self._wrench_stamped.header = message.header
        self._wrench.publish(self._wrench_stamped)
        self._contact.publish(self._bool)


if __name__ == '__main__':
    sys.exit(run(Relay, 'relay'))

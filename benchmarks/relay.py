"""Relay with the subscription and publishers of the node, without computation, as a baseline."""

import sys

from baxter_dynamics_ros.nodes import topics
from baxter_dynamics_ros.nodes.process import run
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.qos_overriding_options import QoSOverridingOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

OUTPUTS = {topics.PREDICTED_EFFORT: JointState, topics.EFFORT_RESIDUAL: JointState,
           topics.EXTERNAL_EFFORT: JointState, topics.EXTERNAL_WRENCH: WrenchStamped,
           topics.CONTACT: Bool}


class Relay(Node):
    """Publishes each joint state of 17 joints three times, cut to seven; a wrench; and a flag."""

    def __init__(self):
        super().__init__('torque_predictor')
        self._publishers_ = [(kind, self.create_publisher(
            kind, f'~/{name}', topics.PUBLISHER_QOS))
            for name, kind in OUTPUTS.items()]
        self.create_subscription(
            JointState, topics.JOINT_STATES, self._on_joint_state, topics.SUBSCRIPTION_QOS,
            qos_overriding_options=QoSOverridingOptions.with_default_policies())

    def _on_joint_state(self, message):
        for field in ('name', 'position', 'velocity', 'effort'):
            setattr(message, field, getattr(message, field)[9:16])
        for kind, publisher in self._publishers_:
            publisher.publish(message if kind is JointState else
                              kind(header=message.header) if kind is WrenchStamped else kind())


if __name__ == '__main__':
    sys.exit(run(Relay, 'relay'))

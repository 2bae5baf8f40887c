"""The private parts of rclpy that the nodes use are still there and do what they should."""

from baxter_dynamics_ros.nodes.rclpy_internals import given_parameters, take_waiting
import rclpy
from rclpy.node import Node
from std_msgs.msg import Bool


def test_waiting_messages_are_taken_in_order(robot):
    subscription = robot.create_subscription(Bool, 'flags', lambda message: None, 10)
    publisher = robot.create_publisher(Bool, 'flags', 10)
    robot.until(lambda: publisher.get_subscription_count() == 1)
    sent = [True, False, True, True]
    for flag in sent:
        publisher.publish(Bool(data=flag))
    taken = []
    while len(taken) < len(sent):
        taken += [message.data for message, _ in take_waiting(subscription, 3)]
    assert taken == sent
    assert list(take_waiting(subscription, 3)) == []


def test_given_parameters_are_known_before_they_are_declared(domain):
    context = rclpy.Context()
    context.init(['node', '--ros-args', '-p', 'mass:=1.5', '-p', 'side:=left'])
    try:
        node = Node('given', context=context)
        assert {'mass': 1.5, 'side': 'left'}.items() <= given_parameters(node).items()
        node.destroy_node()
    finally:
        context.shutdown()

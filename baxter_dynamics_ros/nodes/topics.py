"""Names and qualities of service of all topics and services, in one place."""

from rclpy.qos import QoSProfile, ReliabilityPolicy

JOINT_STATES = '/robot/joint_states'
DIAGNOSTICS = '/diagnostics'
RESET = '~/reset'

# Below the node.
PREDICTED_EFFORT = 'predicted_effort'
EFFORT_RESIDUAL = 'effort_residual'
EXTERNAL_EFFORT = 'external_effort'
EXTERNAL_WRENCH = 'external_wrench'
CONTACT = 'contact'
GRAVITY_TORQUES = 'gravity_torques'
INVERSE_DYNAMICS = 'inverse_dynamics'

# Below the fake Baxter, so that what commands it commands no robot.
JOINT_TORQUE_COMMAND = 'joint_torque_command'

# Sensor data: best effort, so that any publisher matches. Its queue is longer than the usual 5,
# since a filter wants every sample: 5 are 5 ms at 1000 Hz, 1000 bridge a pause of a second.
# Parameters qos_overrides.* change it.
SUBSCRIPTION_QOS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
# Reliable and volatile like the bridge's own, so that any subscriber matches; deeper than its 10,
# so that a subscriber that pauses for a second misses nothing at 100 Hz.
PUBLISHER_QOS = QoSProfile(depth=100)


def below_node(name: str) -> str:
    """Return a name in the node's own namespace."""
    return f'~/{name}'

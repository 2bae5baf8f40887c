"""Names and QoS profiles of topics and services."""

from rclpy.qos import QoSProfile, ReliabilityPolicy

JOINT_STATES = '/robot/joint_states'
DIAGNOSTICS = '/diagnostics'

# Names below the node's name.
PREDICTED_EFFORT = 'predicted_effort'
EFFORT_RESIDUAL = 'effort_residual'
RESIDUAL_DEVIATION = 'residual_deviation'
EXTERNAL_EFFORT = 'external_effort'
EXTERNAL_WRENCH = 'external_wrench'
CONTACT = 'contact'
GRAVITY_TORQUES = 'gravity_torques'
INVERSE_DYNAMICS = 'inverse_dynamics'
PAYLOAD_ESTIMATE = 'payload_estimate'
RESET = 'reset'
ZERO = 'zero'
CALIBRATE = 'calibrate'

# Below the fake Baxter, so that a real robot never receives its commands.
JOINT_TORQUE_COMMAND = 'joint_torque_command'

# Best effort, as for sensor data, so that any publisher matches. The queue is longer than usual,
# because the filter needs every sample: 1000 messages bridge a pause of a second at 1000 Hz.
# Can be changed with parameters qos_overrides.*.
SUBSCRIPTION_QOS = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
# Reliable and volatile, so that any subscriber matches. The depth lets a subscriber pause for a
# second at 100 Hz without losing messages.
PUBLISHER_QOS = QoSProfile(depth=100)

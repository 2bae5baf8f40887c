"""Names and qualities of service of all topics and services, in one place."""

from rclpy.qos import QoSProfile
from rclpy.qos import ReliabilityPolicy

JOINT_STATES = '/robot/joint_states'
DIAGNOSTICS = '/diagnostics'

PREDICTED_EFFORT = '~/predicted_effort'
EFFORT_RESIDUAL = '~/effort_residual'
GRAVITY_TORQUES = '~/gravity_torques'
INVERSE_DYNAMICS = '~/inverse_dynamics'
RESET = '~/reset'

# Sensor data: best effort, so that any publisher matches. Its queue is longer than the usual 5,
# since a filter wants every sample: 5 are 5 ms at 1000 Hz, 100 bridge any pause of the process.
# Parameters qos_overrides.* change it.
SUBSCRIPTION_QOS = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
# Reliable, volatile, depth 10: the bridge's own, and ours, so that any subscriber matches.
PUBLISHER_QOS = QoSProfile(depth=10)

"""Names and qualities of service of all topics and services, in one place."""

from rclpy.qos import qos_profile_sensor_data
from rclpy.qos import QoSProfile

JOINT_STATES = '/robot/joint_states'
DIAGNOSTICS = '/diagnostics'

PREDICTED_EFFORT = '~/predicted_effort'
EFFORT_RESIDUAL = '~/effort_residual'
GRAVITY_TORQUES = '~/gravity_torques'
INVERSE_DYNAMICS = '~/inverse_dynamics'
RESET = '~/reset'

# Best effort, so that any publisher matches; parameters qos_overrides.* change it.
SUBSCRIPTION_QOS = qos_profile_sensor_data
# Reliable, volatile, depth 10: the bridge's own, and ours, so that any subscriber matches.
PUBLISHER_QOS = QoSProfile(depth=10)

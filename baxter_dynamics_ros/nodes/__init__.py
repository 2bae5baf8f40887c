"""The ROS 2 shell: translates messages, parameters and services; decides nothing."""

"""ROS 2 nodes: messages, parameters, services and diagnostics."""

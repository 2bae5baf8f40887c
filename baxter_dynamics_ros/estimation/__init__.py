"""Predicted effort, residual, external torque and contact from joint states, without ROS."""

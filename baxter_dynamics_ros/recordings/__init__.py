"""Recordings: read and written without ROS, predicted by the node's own code, and judged."""

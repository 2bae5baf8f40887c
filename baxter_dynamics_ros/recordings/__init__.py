"""Recordings: readers and writers without ROS, and their evaluation by the node's own code."""

"""Read-only client of a ROS 1 master and its publishers: standard library only, no ROS."""

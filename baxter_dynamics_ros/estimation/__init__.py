"""From a stream of joint states to predictions and residuals; knows NumPy and no ROS."""

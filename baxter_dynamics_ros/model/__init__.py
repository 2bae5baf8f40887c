"""Dynamics, kinematics and effort model of the arm; needs only NumPy."""

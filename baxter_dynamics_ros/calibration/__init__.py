"""Calibration of effort model and links from recordings, by regularised least squares."""

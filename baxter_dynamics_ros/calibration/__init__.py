"""From recordings to the effort model of one's own robot: regularised least squares."""

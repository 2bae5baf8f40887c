"""The arm's dynamics, with NumPy and nothing else."""

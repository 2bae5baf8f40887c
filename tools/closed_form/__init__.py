"""Generator of the closed form: symbolic derivation, operation counts, Python and C output."""

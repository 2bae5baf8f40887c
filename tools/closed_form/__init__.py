"""The closed form on symbols: derived, counted and written as Python and C."""

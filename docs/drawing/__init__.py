"""Figures of the documentation, one module per page or kind."""

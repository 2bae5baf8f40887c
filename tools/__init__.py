"""What only developers of this package run; not installed."""

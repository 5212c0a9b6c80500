"""G-code."""

"""The way back to the path."""

"""The independent verification."""

"""The command `tolerance`."""

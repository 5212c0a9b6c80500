"""The command `time`."""

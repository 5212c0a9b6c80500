"""The folder of a plan."""

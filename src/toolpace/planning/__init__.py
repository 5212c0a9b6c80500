"""Planners: from a joint path to a motion over time."""

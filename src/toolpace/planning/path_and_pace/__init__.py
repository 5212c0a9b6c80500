"""Optimisation of path and speed law together."""

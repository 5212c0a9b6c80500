"""Cutting forces: of one engagement that a tool file states, and of a table of engagement along a motion."""

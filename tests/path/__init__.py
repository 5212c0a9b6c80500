"""Paths of tip and tool axis."""

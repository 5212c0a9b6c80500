"""Cutting forces and the bending of the tool."""

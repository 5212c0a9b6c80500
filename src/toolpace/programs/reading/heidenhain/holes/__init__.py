"""Drilling cycles and hole patterns."""

"""Cycles of holes and their patterns."""

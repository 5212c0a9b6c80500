"""Tolerances of a path by place."""

"""Kernels of path and pace changed together."""

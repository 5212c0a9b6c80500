"""Kernels of the other planners."""

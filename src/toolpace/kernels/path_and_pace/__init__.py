"""Kernels of the simultaneous optimisation of path and speed law."""

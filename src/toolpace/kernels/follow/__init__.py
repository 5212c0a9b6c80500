"""Kernels of the follower: path, pace and correction within the limits at every step."""

"""Kernels of the optimal planner and of its bound: interior-point methods."""

"""Kernels of control models: the speed from block to block."""

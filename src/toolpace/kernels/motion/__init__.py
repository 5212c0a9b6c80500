"""Kernels of time laws and of limit utilisation."""

"""Kernels of the fit: quintic splines inside a tube."""

"""Kernels of the judge, shared with no other room."""

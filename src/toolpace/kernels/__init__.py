"""Compiled functions of plain arrays: numba and numpy only, nothing of toolpace."""

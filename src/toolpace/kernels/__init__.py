"""Compiled functions of plain arrays (numba); they import nothing else of toolpace."""

"""Contour elements: lines, arcs, polar forms, corners."""

"""Elements of contours: lines, arcs, polar ones, corners."""

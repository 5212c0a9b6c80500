"""Cutter radius compensation: from the programmed contour to the path of the tool centre."""

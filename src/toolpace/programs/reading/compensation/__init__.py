"""Cutter radius compensation: from the contour that a program tells to the way of the tool's centre."""

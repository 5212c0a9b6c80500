"""Smooth curves of tool tip and tool axis, fitted to a program or exact; and the paths of joints."""

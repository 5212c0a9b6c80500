"""Smooth curves of tool tip and tool axis: fitted to a program, or given exactly."""

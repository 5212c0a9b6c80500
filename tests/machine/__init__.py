"""Kinematics, the choice of rotary positions, machine files."""

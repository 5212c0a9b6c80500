"""Coordinates of a program: frames, offsets, set-up sheet, kinematics."""

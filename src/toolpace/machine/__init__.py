"""A five-axis machine: its file, its kinematics, its limits, and what it refuses."""

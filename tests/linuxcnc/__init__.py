"""The real LinuxCNC beside ours: kinematics, and the harness that runs it."""

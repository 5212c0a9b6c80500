"""What a control makes of a motion: cycle times, files that it loads, LinuxCNC's HAL."""

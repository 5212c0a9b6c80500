"""What LinuxCNC plays: rows for its HAL, programs for its interpreter."""

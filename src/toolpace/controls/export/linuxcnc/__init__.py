"""Exports for LinuxCNC: rows for its HAL, programs for its interpreter."""

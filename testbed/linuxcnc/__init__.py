"""LinuxCNC as a judge: its interpreter beside our reading, and the whole control, headless, logged each servo cycle."""

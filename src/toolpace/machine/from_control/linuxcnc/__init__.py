"""LinuxCNC: an INI with the HAL files that it names."""

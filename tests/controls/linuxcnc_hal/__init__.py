"""The component of LinuxCNC's HAL, without LinuxCNC."""

"""A follower as a user-space component of LinuxCNC's HAL."""

from toolpace.controls.linuxcnc_hal.component import Component, Settings
from toolpace.controls.linuxcnc_hal.linuxcnc import hal_module

__all__ = ["Component", "Settings", "hal_module"]

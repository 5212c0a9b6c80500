"""A follower as a component of LinuxCNC's HAL: not realtime, a few rows ahead of the realtime side that plays them."""

from toolpace.controls.linuxcnc_hal.component import Component, Settings
from toolpace.controls.linuxcnc_hal.linuxcnc import hal_module

__all__ = ["Component", "Settings", "hal_module"]

"""A plan followed live: set-point by set-point, at any pace, corrected by what is measured, within every limit."""

from toolpace.follow.follower import Follower
from toolpace.follow.measurement import Measurement
from toolpace.follow.setpoint import SetPoint, Status

__all__ = ["Follower", "Measurement", "SetPoint", "Status"]

"""The follower: a plan played set-point by set-point, at any pace, corrected by measurements within all limits."""

from toolpace.deflection.following.follower import Follower
from toolpace.deflection.following.signals import Measurement, SetPoint, Status

__all__ = ["Follower", "Measurement", "SetPoint", "Status"]

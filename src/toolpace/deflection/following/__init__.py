"""The follower: a plan played set-point by set-point, at any pace, corrected by measurements within all limits."""

from toolpace.deflection.following.follower import Follower, Measurement, SetPoint, Status

__all__ = ["Follower", "Measurement", "SetPoint", "Status"]

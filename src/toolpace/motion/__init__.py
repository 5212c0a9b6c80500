"""Joint motion over time, and its utilisation of the limits."""

from __future__ import annotations

from toolpace.motion.usage import (
    Motion,
    Usage,
    closer_look,
    gained_in_a_ramp,
    jerk_jumps,
    joint_motion,
    least_changes,
    limit_ratios,
)

__all__ = [
    "Motion", "Usage", "closer_look", "gained_in_a_ramp", "jerk_jumps", "joint_motion", "least_changes", "limit_ratios",
]  # fmt: skip

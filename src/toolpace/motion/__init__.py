"""Joint motion over time, and its utilisation of the limits."""

from __future__ import annotations

from toolpace.motion.adaptive_sampling import closer_look, gained_in_a_ramp, least_changes
from toolpace.motion.usage import Motion, Usage, jerk_jumps, joint_motion, limit_ratios

__all__ = [
    "Motion", "Usage", "closer_look", "gained_in_a_ramp", "jerk_jumps", "joint_motion", "least_changes", "limit_ratios",
]  # fmt: skip

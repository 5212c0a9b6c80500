"""Replanning after a deflection: projection on the path, and the motion back onto it."""

from toolpace.deflection.replanning.new_trajectory import replan
from toolpace.deflection.replanning.pose import deflected_pose
from toolpace.deflection.replanning.projection import Projection, force, potential, project

__all__ = ["Projection", "deflected_pose", "force", "potential", "project", "replan"]
